#pragma once
// The look at the whole cell for what asks for a person, every two seconds of cell time.

#include <boost/asio/any_io_executor.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/application/access/access_desk.h"
#include "server/application/alarms/alarm_book.h"
#include "server/application/alarms/alarm_conditions.h"
#include "server/application/alarms/alarms.h"
#include "server/application/alarms/channel_alarms.h"
#include "server/application/alarms/incidents.h"
#include "server/application/checks/model_checks_service.h"
#include "server/application/holds/hold_desk.h"
#include "server/application/manual/manual_control_service.h"
#include "server/application/motion/workbench.h"
#include "server/application/notify/notify_desk.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/provenance/configuration_book.h"
#include "server/application/queue/queue_desk.h"
#include "server/application/runs/right_to_move.h"
#include "server/application/runs/run_engine.h"
#include "server/application/serving/serving.h"
#include "server/application/status/overview.h"
#include "server/application/upkeep/database_upkeep.h"

namespace driftwise::application {

class AlarmsService final : public Alarms {
 public:
  struct Sources {  // all of them outlive this
    Workbench& bench;
    const Overview& overview;
    const RunEngine& engine;
    const RightToMove& right;
    const ManualControlService& manual;
    const Serving& serving;
    const ModelChecksService& checks;
    const ConfigurationBook& configuration;
    const DatabaseUpkeep& upkeep;
    const AccessDesk& access;
    const NotifyDesk& notify;
    const HoldDesk& holds;
    const QueueDesk& queue;
  };
  AlarmsService(asio::any_io_executor executor, Sources sources, StoreReader& reader,
                AlarmBook& book, TaskGroup& tasks);

  Awaitable<Result<std::vector<AlarmRecord>>> list(bool with_history, int limit) override;
  Awaitable<Result<AlarmRecord>> acknowledge(Caller caller, AlarmId id) override;
  Awaitable<Result<AlarmRecord>> shelve(Caller caller, AlarmId id, double for_s,
                                        std::string reason) override;
  Awaitable<Result<AlarmRecord>> unshelve(Caller caller, AlarmId id) override;
  std::vector<AlarmRecord> unwritten(std::size_t most) const override;

  void start();  // looks until shut_down()
  void shut_down();
  void look_now() { wake_.raise(); }
  // The start is done: serving and an unfinished run go on, and their silence counts from now on.
  void note_start_is_done() { start_is_done_ = true; }
  void note_progress(const RunProgress& progress);
  void note(AlarmCondition condition);  // it happened and is over at once

 private:
  Awaitable<void> look_for_ever();
  std::vector<AlarmCondition> alarms_now() const;
  // Whether the source of an alarm of before the start has looked at its condition since
  // (alarm_book.h): alarms_judged.cc.
  bool has_judged(const AlarmRecord& alarm) const;
  bool has_judged_run(const AlarmRecord& alarm) const;
  // For sources that say nothing of themselves: the longest time that they need.
  double needed_s(const AlarmRecord& alarm) const;
  void note_clock_jumps();
  void look_at_channels();
  std::optional<double> force_now() const;  // on the end-effector, as far as it is known

  asio::any_io_executor executor_;
  const CellDescription& description_;
  Clock& clock_;
  DeviceBench& bench_;
  Recorder& recorder_;
  StoreWriter& writer_;
  EventLog& events_;
  Loading& loading_;
  StopDesk& stops_;
  Doubts& doubts_;
  const Overview& overview_;
  const RunEngine& engine_;
  const RightToMove& right_;
  const ManualControlService& manual_;
  const Serving& serving_;
  const ModelChecksService& checks_;
  const ConfigurationBook& configuration_;
  const DatabaseUpkeep& upkeep_;
  const AccessDesk& access_;
  const NotifyDesk& notify_;
  const HoldDesk& holds_;
  const QueueDesk& queue_;
  StoreReader& reader_;
  AlarmBook& book_;
  TaskGroup& tasks_;
  Incidents incidents_;
  QualityTrend quality_;
  ChannelAlarms channel_alarms_;
  std::optional<RunId> last_failed_;                 // of which an alarm was made
  std::map<std::string, std::int64_t> clock_jumps_;  // by device, of which an event was made
  CellTime started_;
  bool start_is_done_ = false;
  Signal wake_;
  bool ending_ = false;
};

}  // namespace driftwise::application
