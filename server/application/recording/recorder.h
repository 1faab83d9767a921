#pragma once
// Reads every slow device every period, always, run or no run; keeps the latest values and the last
// minutes, hands every reading to the store and to watchers. The axes, an interferometer or an
// autocollimator are read here only while no run uses them: the run's own readings come in through
// observe(). Between runs those without a period of their own are read every kIdlePeriod_s, shown,
// and not stored. The store
// keeps what a device said under the device's own channels; live values show it under raw names
// where the cell corrects it (x_path_mm), and the pose beside it.

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
  // Interferometers, autocollimators: what a run reads by itself.
  void lend_pose_instruments(bool to_run) { lent_ = to_run; }

  const ChannelHistory& history() const { return history_; }
  // Resumes at the next reading of any device, or at the instant.
  Awaitable<void> next_reading_until(CellTime instant);

  WatchList<Reading>& watchers() { return watchers_; }

 private:
  static constexpr double kIdlePeriod_s = 2.0;
  enum class Kind { scanner, stabiliser, interferometer, collimator, load, controller };
  const DeviceDescription& description_of(Kind kind, std::size_t i) const;
  Awaitable<void> read_for_ever(Kind kind, std::size_t i);
  Awaitable<void> flush_for_ever();
  Awaitable<Result<JudgedReading>> read(Kind kind, std::size_t i);
  Awaitable<Result<JudgedReading>> read_axes();
  static bool belongs_to_run(Kind kind) {
    return kind == Kind::interferometer || kind == Kind::collimator || kind == Kind::controller;
  }
  double period_s(Kind kind, std::size_t i) const;  // 0: never read here

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
  bool ending_ = false, lent_ = false;
  std::int64_t axes_sequence_ = 0;
};

}  // namespace driftwise::application
