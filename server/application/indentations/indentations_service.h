#pragma once

#include "server/application/indentations/indentations.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/store_writer.h"

namespace driftwise::application {

class IndentationsService final : public Indentations {
 public:
  // texts: the thread on which files are read. All of them outlive this.
  IndentationsService(Clock& clock, StoreReader& reader, StoreWriter& writer, EventLog& events,
                      asio::any_io_executor texts)
      : clock_(clock),
        reader_(reader),
        writer_(writer),
        events_(events),
        texts_(std::move(texts)) {}

  Awaitable<Result<IndentationView>> begin(Caller caller, std::string key, std::string file_text,
                                           std::string record_json) override;
  Awaitable<Result<IndentationView>> report(Caller caller, IndentationId id,
                                            std::string record_json, std::string ended) override;
  Awaitable<Result<IndentationView>> import_table(Caller caller, IndentationId id,
                                                  std::string microscope_csv) override;
  Awaitable<Result<std::vector<IndentationView>>> list(int limit) override;
  Awaitable<Result<IndentationView>> get(IndentationId id) override;

 private:
  // Replaces the last report by this one, where it continues it.
  Awaitable<Result<IndentationView>> replace(Caller caller, IndentationRecord stored,
                                             std::string file_text, std::string record_json,
                                             std::string ended);

  Clock& clock_;
  StoreReader& reader_;
  StoreWriter& writer_;
  EventLog& events_;
  asio::any_io_executor texts_;
};

}  // namespace driftwise::application
