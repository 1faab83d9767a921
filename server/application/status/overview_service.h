#pragma once

#include <string>
#include <vector>

#include "server/application/checks/model_checks_service.h"
#include "server/application/manual/manual_control_service.h"
#include "server/application/motion/workbench.h"
#include "server/application/notify/notify_desk.h"
#include "server/application/plumbing/pause_meter.h"
#include "server/application/provenance/configuration_book.h"
#include "server/application/runs/run_engine.h"
#include "server/application/serving/serving.h"
#include "server/application/status/overview.h"
#include "server/application/upkeep/database_upkeep.h"

namespace driftwise::application {

class OverviewService final : public Overview {
 public:
  struct Program {
    std::string version;
    std::string web_address;  // "http://127.0.0.1:8080/"; empty: no web door
  };
  struct Sources {  // all of them outlive this
    Workbench& bench;
    const RunEngine& engine;
    const LeaseBook& leases;
    const ManualControlService& manual;
    const Serving& serving;
    const ModelChecksService& checks;
    const ConfigurationBook& configuration;
    const DatabaseUpkeep& upkeep;
    const PauseMeter& pauses;
    const NotifyDesk& notify;
  };
  OverviewService(Program program, Sources sources);

  CellStatus status() const override;
  const CellDescription& description() const override { return description_; }

 private:
  std::vector<std::string> attention() const;

  Program program_;
  const CellDescription& description_;
  Clock& clock_;
  DeviceBench& bench_;
  Recorder& recorder_;
  StoreWriter& writer_;
  StopDesk& stops_;
  const RunEngine& engine_;
  const LeaseBook& leases_;
  const ManualControlService& manual_;
  const Serving& serving_;
  const ModelChecksService& checks_;
  const ConfigurationBook& configuration_;
  const DatabaseUpkeep& upkeep_;
  const PauseMeter& pauses_;
  const NotifyDesk& notify_;
};

}  // namespace driftwise::application
