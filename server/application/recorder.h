#pragma once
// Reads every slow device every period, always, run or no run; keeps the latest values and the last
// minutes, hands every reading to the store and to watchers. An interferometer or autocollimator is
// read here only while no run uses it: the run's own readings come in through observe(). The store
// keeps what a device said under the device's own channels; live values show it under raw names
// where the cell corrects it (x_path_mm), and the pose beside it.

#include <functional>
#include <span>
#include <vector>

#include "server/application/channel_history.h"
#include "server/application/device_bench.h"
#include "server/application/event_log.h"
#include "server/application/lag_meter.h"
#include "server/application/pose_stage.h"
#include "server/application/store_writer.h"

namespace driftwise::application {

class Recorder {
 public:
  Recorder(asio::any_io_executor executor, Clock& clock, DeviceBench& bench, StoreWriter& writer,
           EventLog& events, LagMeter& lag, const PoseStage& pose, TaskCount& tasks);

  void start();
  void shut_down();  // the loops end after the reading under way; TaskCount says when

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
  enum class Kind { scanner, stabiliser, interferometer, collimator, load };
  const DeviceDescription& description_of(Kind kind, std::size_t i) const;
  Awaitable<void> read_for_ever(Kind kind, std::size_t i);
  Awaitable<void> flush_for_ever();
  Awaitable<Result<JudgedReading>> read(Kind kind, std::size_t i);

  asio::any_io_executor executor_;
  Clock& clock_;
  DeviceBench& bench_;
  StoreWriter& writer_;
  EventLog& events_;
  LagMeter& lag_;
  const PoseStage& pose_;
  TaskCount& tasks_;
  ChannelHistory history_;
  WatchList<Reading> watchers_;
  Signal ended_, arrived_;
  bool ending_ = false, lent_ = false;
};

}  // namespace driftwise::application
