#pragma once

#include <boost/asio/any_io_executor.hpp>

#include "server/application/datasets/datasets.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"
#include "server/core/description/cell_description.h"

namespace driftwise::application {

class DatasetsService final : public Datasets {
 public:
  // background: where texts are read. All of them outlive this.
  DatasetsService(const CellDescription& description, Clock& clock, StoreReader& reader,
                  StoreWriter& writer, EventLog& events, asio::any_io_executor background)
      : description_(description),
        clock_(clock),
        reader_(reader),
        writer_(writer),
        events_(events),
        background_(std::move(background)) {}

  Awaitable<Result<Dataset>> load(std::vector<RunId> runs, std::string csv) override;
  Awaitable<Result<std::vector<std::string>>> set_names(std::vector<RunId> runs,
                                                        std::string csv) override;
  Awaitable<Result<std::string>> export_csv(std::vector<RunId> runs,
                                            bool without_excluded) override;
  Awaitable<Result<RunRecord>> import_csv(Caller caller, std::string name, std::string csv,
                                          std::string request_id) override;
  Awaitable<Result<JoinAnswer>> join(Caller caller, JoinRequest request) override;

 private:
  const CellDescription& description_;
  Clock& clock_;
  StoreReader& reader_;
  StoreWriter& writer_;
  EventLog& events_;
  asio::any_io_executor background_;
};

}  // namespace driftwise::application
