#pragma once
// What the parts of the engine work with. References into the Cell, which outlives every run.

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/application/motion/run_control.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/lag_meter.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/recording/axes_to_move.h"
#include "server/application/recording/device_bench.h"
#include "server/application/recording/pose_stage.h"
#include "server/application/recording/recorder.h"

namespace driftwise::application {

class Doubts;
class Loading;
class StopDesk;

struct Workbench {
  const CellDescription& description;
  Clock& clock;
  DeviceBench& devices;
  Recorder& recorder;
  StoreWriter& writer;
  EventLog& events;
  LagMeter& lag;
  PoseStage& pose;
  Loading& loading;
  StopDesk& stops;
  Doubts& doubts;
  const std::string& boot_id;  // of this start of the computer; empty: not known
};

// A place that a run's axes reached, until a point stands for it or it is a row of its own
// (runs/passages.h).
struct Passage {
  CellTime in_position;
  Stamp at;  // in position; the middle of its readings where it was read
  std::vector<double> commanded_mm, q_mm;
  std::optional<double> force_n;
  std::vector<ChannelValue> values;  // empty: no instrument was read there
};

// One run's view of it.
struct RunScope {
  Workbench& bench;
  RunControl& control;
  RunRules rules;
  std::optional<RunId> run;                // none: a movement by hand
  std::function<void(std::string)> phase;  // shown to watchers: "moving"
  std::function<Awaitable<Result<void>>(std::string)>
      enter_waiting;  // state waiting, with the reason, on record
  std::function<Awaitable<Result<void>>()> leave_waiting;  // ... and running again
  // Since when the axes stand where they were sent; none: they are on their way.
  std::optional<CellTime> at_rest = {};
  std::string sides = {};  // from which each axis came where it is: '+', '-', '?'; one per axis
  AxesToMove moved = {};   // by the rows of the run; the others stay at 0
  std::vector<Passage> passed = {};  // oldest first

  // Until the instant, or earlier with an error when the run is aborted or the daemon ends.
  Awaitable<Result<void>> sleep_until(CellTime instant) {
    while (bench.clock.now().utc < instant) {
      if (auto ok = control.check(); !ok) co_return ok;
      co_await bench.lag.sleep_unless(instant, control.changed());
    }
    co_return control.check();
  }
  Awaitable<Result<void>> sleep_s(double seconds) {
    return sleep_until(bench.clock.now().utc + nanoseconds_from_s(seconds));
  }
};

}  // namespace driftwise::application
