#pragma once
// The cell's devices, each asked by one at a time, and each watched: lost once, back once.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/application/plumbing/signal.h"
#include "server/application/ports/cell.h"
#include "server/application/recording/motion_watch.h"
#include "server/core/data/judged_reading.h"
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

  // Motion that nobody here commanded is told from now on, once each time (motion_watch.h), from
  // within the call that saw it. instruments_say: whether the axes are there by what the
  // interferometers measure; false also where that is not known.
  void watch_motion(double limit_nm,
                    std::function<Awaitable<bool>(std::vector<double> q_mm)> instruments_say,
                    std::function<void(const std::string&)> on_uncommanded);
  bool has_controller() const { return controller_ != nullptr; }

  // Errors besides the devices': IMPLAUSIBLE (server/application/recording/doubts.h), here and in
  // load_state. A reading says itself what of it was rejected.
  Awaitable<Result<MotionState>> motion_state();
  Awaitable<Result<void>> home();
  Awaitable<Result<void>> start_move(std::vector<double> q_mm);
  Awaitable<Result<void>> stop();  // takes no lock: it interrupts whatever the controller is doing
  // Asked at the instant at which home(), start_move() and set_load() would be sent; its error is
  // theirs, and nothing is sent.
  void allow_motion_if(std::function<Result<void>()> gate) { gate_ = std::move(gate); }

  std::size_t interferometers() const { return interferometers_.size(); }
  std::size_t collimators() const { return collimators_.size(); }
  bool has_load() const { return load_ != nullptr; }
  std::size_t scanners() const { return scanners_.size(); }
  std::size_t stabilisers() const { return stabilisers_.size(); }
  Awaitable<Result<JudgedReading>> read_interferometer(std::size_t i);
  Awaitable<Result<JudgedReading>> read_collimator(std::size_t i);
  // Every interferometer, then every collimator, all asked at the same time: what belongs to one
  // pose. The first that fails, in that order, is the answer; the others are waited for.
  Awaitable<Result<std::vector<JudgedReading>>> read_pose_instruments();
  Awaitable<Result<void>> zero_interferometer(std::size_t i);
  Awaitable<Result<JudgedReading>> read_scanner(std::size_t i);
  Awaitable<Result<JudgedReading>> read_stabiliser(std::size_t i);
  Awaitable<Result<void>> set_stabiliser(std::size_t i, double degc);
  // Only with has_load().
  Awaitable<Result<LoadState>> load_state();
  Awaitable<Result<void>> set_load(double force_n);
  Awaitable<Result<JudgedReading>>
  read_load();  // the force as a reading; missing while weights move

  const DeviceDescription& controller_description() const;
  const DeviceDescription& interferometer_description(std::size_t i) const;
  const DeviceDescription& collimator_description(std::size_t i) const;
  const DeviceDescription& load_description() const;
  const DeviceDescription& scanner_description(std::size_t i) const;
  const DeviceDescription& stabiliser_description(std::size_t i) const;

  // Connects what is not connected. The first error ends it.
  Awaitable<Result<void>> prepare_for_run();
  // Connects one device, where it is not connected; counted in the order of status().
  Awaitable<Result<void>> prepare(std::size_t device);
  std::vector<DeviceStatus> status() const;
  std::vector<std::string> lost() const;  // ids of the devices that do not answer
  void close_all();

 private:
  template <class Port>
  struct Seat {
    Seat(const asio::any_io_executor& executor, std::unique_ptr<Port> d)
        : device(std::move(d)), mutex(executor) {}
    std::unique_ptr<Port> device;
    AsyncMutex mutex;
    int failures = 0;
    bool lost = false;
  };
  template <class Port, class Call>
  auto ask(Seat<Port>& seat, Call call) -> std::invoke_result_t<Call, Port&>;
  template <class Port, class R>
  void note(Seat<Port>& seat, const R& result);
  Awaitable<void> read_into(Seat<Instrument>& seat, std::optional<Result<JudgedReading>>& place);
  template <class Visit>
  void for_each_seat(Visit visit) const;

  template <class Port, class Call>
  Awaitable<Result<void>> ask_to_move(Seat<Port>& seat, Call call);

  Awaitable<Result<JudgedReading>> read_judged(Seat<Instrument>& seat);
  Awaitable<void> look_for_motion(MotionState state);

  Doubts& doubts_;
  OnChange on_change_;
  std::function<Result<void>()> gate_ = [] { return Result<void>{}; };
  std::optional<MotionWatch> motion_watch_;
  std::function<Awaitable<bool>(std::vector<double>)> instruments_say_;
  std::function<void(const std::string&)> on_uncommanded_;
  std::unique_ptr<Seat<MotionController>> controller_;
  std::vector<std::unique_ptr<Seat<Instrument>>> interferometers_, collimators_, scanners_;
  std::vector<std::unique_ptr<Seat<Stabiliser>>> stabilisers_;
  std::unique_ptr<Seat<LoadActuator>> load_;
  std::int64_t load_sequence_ = 0;
};

// True for what a device that is away does to a call; false for a refusal, which asking again does
// not change.
bool is_device_loss(const Error& error);

}  // namespace driftwise::application
