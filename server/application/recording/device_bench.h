#pragma once
// The cell's devices in one list, each asked by one at a time, and each watched: lost once, back
// once. A device's place in the list is its number: by role (DeviceRole), within a role as in the
// cell file.
//
// The only mutual exclusion of a device's line is here (server/core/ports/device.h).
//
// Several motion controllers move as one: axes are numbered through, in the order of the cell file.

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/application/recording/axes_to_move.h"
#include "server/application/recording/device_status.h"
#include "server/application/recording/devices.h"
#include "server/application/recording/motion_watch.h"
#include "server/application/recording/setup_in_use.h"
#include "server/core/data/judged_reading.h"
#include "server/core/devices/loop_tuning.h"
#include "server/core/ports/async_mutex.h"

namespace driftwise::application {

class Doubts;

class DeviceBench {
 public:
  // on_change: called when a device stops answering (with the error) and when it answers again
  // (nullptr).
  using OnChange = std::function<void(const DeviceDescription&, const Error*)>;
  // Every answer is shown to it before anybody else has it. doubts: outlives this.
  DeviceBench(asio::any_io_executor executor, Devices devices, Doubts& doubts, OnChange on_change);
  ~DeviceBench();

  std::size_t size() const { return slots_.size(); }
  const DeviceDescription& description(std::size_t device) const;
  // Numbers of the devices with this role; of instruments that measure the pose those of the set-up
  // in use.
  const std::vector<std::size_t>& with_role(DeviceRole role) const {
    return by_role_[static_cast<std::size_t>(role)];
  }
  bool has(DeviceRole role) const { return !with_role(role).empty(); }

  // Instruments that measure the pose and are not named by the set-up are neither read nor prepared
  // for a run from now on; nullptr: all are. setup: outlives its use.
  void use(const SetupDescription* setup);
  const SetupDescription* setup() const { return setup_.get(); }
  // Every coordinate that the set-up in use takes from this device may be out of range.
  bool may_be_lost(std::size_t device) const { return setup_.may_lose(description(device).id); }

  // What the device says now: an instrument's reading, the axes' readback, the load's force.
  // Errors besides the devices': those of judging a motion state, below. A reading says itself what
  // of it was rejected.
  Awaitable<Result<JudgedReading>> read(std::size_t device);
  // Every device in use that measures the pose, all asked at the same time. The first that fails,
  // by number, is the answer; the others are waited for. One that may be lost, and is, gives no
  // reading; at the zero it must be there.
  Awaitable<Result<std::vector<JudgedReading>>> read_pose_instruments(bool at_zero = false);
  // Only of devices behind the port Instrument, and Stabiliser.
  Awaitable<Result<void>> zero(std::size_t device);
  // Every length in use counts from a zero that its instrument still has: what it reads can be
  // compared with what it read before the start of this process.
  bool knows_zeros() const;
  Awaitable<Result<void>> set_point(std::size_t device, double degc);
  // Errors besides: failed_precondition NO_STABILISER, it has no TunableLoop.
  Awaitable<Result<LoopTuning>> tuning(std::size_t device);
  LoopTuning declared_tuning(std::size_t device) const;
  Awaitable<Result<LoopTuning>> set_tuning(std::size_t device, LoopTuning wanted);

  // Motion that nobody here commanded, or that the controller ended, is told from now on, once each
  // time (motion_watch.h), from
  // within the call that saw it. instruments_say: whether the axes are there by what the
  // interferometers measure; false also where that is not known.
  void watch_motion(double limit_nm,
                    std::function<Awaitable<bool>(std::vector<double> q_mm)> instruments_say,
                    std::function<void(const MotionFinding&)> on_uncommanded);
  // Of every controller, by its place among them, all asked at the same time. Where one gives no
  // answer the others that are moving are halted. Errors besides the devices': NO_CONTROLLER;
  // IMPLAUSIBLE (server/application/recording/doubts.h), also in load_state.
  Awaitable<Result<std::vector<MotionState>>> motion_states();
  // The same as one: axes in the cell's order, moving where one moves, at rest when all are.
  Awaitable<Result<MotionState>> motion_state();
  // One controller after the other: where an axis is on its way to its reference is not known.
  Awaitable<Result<void>> home();
  // q_mm: one per axis of the cell. Only controllers of the axes to move are told, all at the same
  // time. Where one refuses, those that took the command are halted.
  Awaitable<Result<void>> start_move(std::vector<double> q_mm, AxesToMove moved = {});
  // Halts the axes of every robot, all controllers at the same time. Does not queue: it interrupts
  // whatever a controller is doing. The first error is the answer, when all have been told.
  Awaitable<Result<void>> stop();
  // The same for one controller, by its number.
  Awaitable<Result<MotionState>> motion_state(std::size_t controller);
  Awaitable<Result<void>> stop(std::size_t controller);
  // Asked at the instant at which home(), start_move() and set_load() would be sent; its error is
  // theirs, and nothing is sent.
  void allow_motion_if(std::function<Result<void>()> gate) { gate_ = std::move(gate); }

  // Only with has(DeviceRole::load).
  Awaitable<Result<LoadState>> load_state();
  Awaitable<Result<void>> set_load(double force_n);
  const DeviceDescription& load_description() const;

  // Connects what is not connected. The first error ends it.
  Awaitable<Result<void>> prepare_for_run();
  // Connects one device, where it is not connected.
  Awaitable<Result<void>> prepare(std::size_t device);
  std::vector<DeviceStatus> status() const;  // by number
  std::vector<std::string> lost() const;     // ids of the devices that do not answer
  void close_all();

 private:
  struct Slot {
    Slot(const asio::any_io_executor& executor, MadeDevice device)
        : made(std::move(device)), mutex(executor) {}
    const DeviceDescription& description() const { return made.device().description(); }
    MadeDevice made;
    AsyncMutex mutex;
    int failures = 0;
    bool lost = false;
    std::int64_t sequence = 0;  // of readings that are made here of a state
    // Of a motion controller.
    std::size_t first_axis = 0;  // place of its first axis among the cell's
    std::optional<MotionWatch> watch;
    std::vector<double> last_q_mm;  // as read back last
  };
  template <class Port, class Call>
  auto ask(Slot& slot, Port& port, Call call) -> std::invoke_result_t<Call, Port&>;
  template <class Port, class Call>
  Awaitable<Result<void>> ask_to_move(Slot& slot, Port& port, Call call);
  template <class R>
  void note(Slot& slot, const R& result);

  // Readback of its axes; empty: where they are is not known.
  void tell_followers(const DeviceDescription& controller, const std::vector<double>& q_mm);
  void release(Slot& slot);  // nobody knows where its axes rest next
  std::vector<Slot*> controllers();
  Awaitable<Result<MotionState>> motion_state(Slot& slot);
  Awaitable<void> state_into(Slot& slot, std::optional<Result<MotionState>>& place);
  Awaitable<Result<void>> move_one(Slot& slot, std::vector<double> q_mm);
  Awaitable<void> move_into(Slot& slot, std::vector<double> q_mm,
                            std::optional<Result<void>>& place);
  Awaitable<Result<void>> stop_one(Slot& slot);
  Awaitable<void> stop_into(Slot& slot, std::optional<Result<void>>& place);
  Awaitable<Result<void>> home_one(Slot& slot);
  std::vector<double> expected_mm(const Slot& looked_at, const MotionWatch& before);
  Slot& load();
  Awaitable<Result<JudgedReading>> read_instrument(Slot& slot, Instrument& instrument);
  Awaitable<Result<JudgedReading>> read_stabiliser(Slot& slot, Stabiliser& stabiliser);
  Awaitable<Result<JudgedReading>> read_axes(Slot& slot, std::size_t device);
  Awaitable<Result<JudgedReading>> read_load(Slot& slot, LoadActuator& actuator);
  Awaitable<void> read_into(std::size_t device, std::optional<Result<JudgedReading>>& place);
  Awaitable<void> look_for_motion(Slot& slot, MotionState state);

  Doubts& doubts_;
  OnChange on_change_;
  std::function<Result<void>()> gate_ = [] { return Result<void>{}; };
  std::function<Awaitable<bool>(std::vector<double>)> instruments_say_;
  std::function<void(const MotionFinding&)> on_uncommanded_;
  std::vector<std::unique_ptr<Slot>> slots_;
  SetupInUse setup_;
  std::array<std::vector<std::size_t>, static_cast<std::size_t>(DeviceRole::supply) + 1> by_role_;
};

// True for what a device that is away does to a call; false for a refusal, which asking again does
// not change.
inline bool is_device_loss(const Error& error) {
  return error.code == ErrorCode::unavailable || error.code == ErrorCode::deadline_exceeded ||
         error.code == ErrorCode::data_loss;
}

// An exchange that was cut off by a stop or the end of the daemon, or refused before it was sent:
// it says nothing about the device.
inline bool is_no_answer(const Error& error) {
  return error.code == ErrorCode::aborted || error.code == ErrorCode::cancelled ||
         error.code == ErrorCode::invalid_argument || error.code == ErrorCode::out_of_range;
}

}  // namespace driftwise::application
