#pragma once
// Reads every slow device every period, always, run or no run; keeps the latest values and the last
// minutes, hands every reading to the store and to watchers. The axes, an interferometer or an
// autocollimator are read here only while no run uses them: the run's own readings come in through
// observe(). Between runs those without a period of their own are read every kIdlePeriod_s, shown,
// and stored only while the cell is at rest by a person's word; the air that they read is stored
// every kEnvironmentPeriod_s. The store keeps what a device said under the device's own channels;
// live values show it under raw names where the cell corrects it (x_path_mm), and the pose beside
// it.

#include <functional>
#include <span>
#include <vector>

#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/lag_meter.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/recording/channel_history.h"
#include "server/application/recording/device_bench.h"
#include "server/application/recording/pose_stage.h"

namespace driftwise::application {

class Recorder {
 public:
  Recorder(asio::any_io_executor executor, Clock& clock, DeviceBench& bench, StoreWriter& writer,
           EventLog& events, LagMeter& lag, const PoseStage& pose, TaskGroup& tasks);

  void start();
  void shut_down();  // the loops end after the reading under way; the TaskGroup says when

  // A reading that somebody else took and stores: it joins and is shown, but is not stored again
  // here.
  void observe(const JudgedReading& reading);
  // What belongs to no device: the pose after the correction stage. Joins and is shown.
  void show(const Reading& reading, std::span<const RejectedValue> rejected = {});
  // Devices that a run reads by itself: is_read_by_runs().
  void lend_pose_instruments(bool to_run) { lent_ = to_run; }
  // A cell at rest: what is read between runs is stored as well.
  void store_idle(bool on) { stores_idle_ = on; }

  const ChannelHistory& history() const { return history_; }
  // Resumes at the next reading of any device, or at the instant.
  Awaitable<void> next_reading_until(CellTime instant);

  WatchList<Reading>& watchers() { return watchers_; }

 private:
  static constexpr double kIdlePeriod_s = 2.0, kEnvironmentPeriod_s = 20.0;
  Awaitable<void> read_for_ever(std::size_t device);
  Awaitable<void> flush_for_ever();
  double period_s(std::size_t device) const;  // 0: never read here

  asio::any_io_executor executor_;
  Clock& clock_;
  DeviceBench& bench_;
  StoreWriter& writer_;
  EventLog& events_;
  LagMeter& lag_;
  const PoseStage& pose_;
  TaskGroup& tasks_;
  ChannelHistory history_;
  WatchList<Reading> watchers_;
  Signal ended_, arrived_;
  bool ending_ = false, lent_ = false, stores_idle_ = false;
};

}  // namespace driftwise::application
