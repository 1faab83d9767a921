#pragma once

#include "server/application/configuration/configurations.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/provenance/configuration_book.h"
#include "server/application/runs/run_engine.h"
#include "server/application/serving/serving.h"

namespace driftwise::application {

class ConfigurationsService final : public Configurations {
 public:
  ConfigurationsService(const CellDescription& description, Clock& clock, StoreReader& reader,
                        StoreWriter& writer, EventLog& events, ConfigurationBook& configuration,
                        RunEngine& engine, Serving& serving)
      : description_(description),
        clock_(clock),
        reader_(reader),
        writer_(writer),
        events_(events),
        configuration_(configuration),
        engine_(engine),
        serving_(serving) {}
  Awaitable<Result<ConfigurationView>> get(std::string hash, std::string compare_hash) override;
  Awaitable<Result<ConfigurationStart>> accept(Caller caller, std::string hash,
                                               std::string note) override;

 private:
  const CellDescription& description_;
  Clock& clock_;
  StoreReader& reader_;
  StoreWriter& writer_;
  EventLog& events_;
  ConfigurationBook& configuration_;
  RunEngine& engine_;
  Serving& serving_;
};

}  // namespace driftwise::application
