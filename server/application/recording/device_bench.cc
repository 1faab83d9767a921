#include "server/application/recording/device_bench.h"

#include <optional>
#include <utility>

#include "server/application/plumbing/task_group.h"
#include "server/application/recording/doubts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {

bool is_device_loss(const Error& error) {
  return error.code == ErrorCode::unavailable || error.code == ErrorCode::deadline_exceeded ||
         error.code == ErrorCode::data_loss;
}

DeviceBench::DeviceBench(asio::any_io_executor executor, Devices devices, Doubts& doubts,
                         OnChange on_change)
    : doubts_(doubts), on_change_(std::move(on_change)) {
  if (devices.controller)
    controller_ = std::make_unique<Seat<MotionController>>(executor, std::move(devices.controller));
  for (auto& d : devices.interferometers)
    interferometers_.push_back(std::make_unique<Seat<Instrument>>(executor, std::move(d)));
  for (auto& d : devices.collimators)
    collimators_.push_back(std::make_unique<Seat<Instrument>>(executor, std::move(d)));
  for (auto& d : devices.scanners)
    scanners_.push_back(std::make_unique<Seat<Instrument>>(executor, std::move(d)));
  for (auto& d : devices.stabilisers)
    stabilisers_.push_back(std::make_unique<Seat<Stabiliser>>(executor, std::move(d)));
  if (devices.load) load_ = std::make_unique<Seat<LoadActuator>>(executor, std::move(devices.load));
}

DeviceBench::~DeviceBench() = default;

template <class Port, class R>
void DeviceBench::note(Seat<Port>& seat, const R& result) {
  // One garbled answer is an error on record (health), not a lost device; no answer at all is one.
  constexpr int kGarbledInARow = 3;
  if (result || !is_device_loss(result.error())) {
    seat.failures = 0;
    if (std::exchange(seat.lost, false)) on_change_(seat.device->description(), nullptr);
    return;
  }
  ++seat.failures;
  const bool is_lost =
      result.error().code != ErrorCode::data_loss || seat.failures >= kGarbledInARow;
  if (is_lost && !std::exchange(seat.lost, true))
    on_change_(seat.device->description(), &result.error());
}

template <class Port, class Call>
auto DeviceBench::ask(Seat<Port>& seat, Call call) -> std::invoke_result_t<Call, Port&> {
  const auto lock = co_await seat.mutex.lock();
  auto result = co_await call(*seat.device);
  note(seat, result);
  co_return result;
}

// The lock may have been waited for: what forbids the motion may be younger than the request.
template <class Port, class Call>
Awaitable<Result<void>> DeviceBench::ask_to_move(Seat<Port>& seat, Call call) {
  const auto lock = co_await seat.mutex.lock();
  if (auto allowed = gate_(); !allowed) co_return allowed;
  auto result = co_await call(*seat.device);
  note(seat, result);
  co_return result;
}

namespace {
// Plain functions of the port: a lambda without captures may be a coroutine's caller, its frame
// holds only arguments.
Error no_controller() {
  return {ErrorCode::failed_precondition, reasons::kNoController,
          "this cell has no motion controller: add one to the cell file"};
}
}  // namespace

Awaitable<Result<MotionState>> DeviceBench::motion_state() {
  if (!controller_) co_return tl::unexpected(no_controller());
  const auto orders = motion_watch_ ? motion_watch_->orders() : 0;
  auto state = co_await ask(*controller_, [](MotionController& c) { return c.state(); });
  if (!state) {
    if (motion_watch_ && is_device_loss(state.error())) motion_watch_->lost();
    co_return state;
  }
  DRIFTWISE_CO_RETURN_IF_ERROR(doubts_.judge(controller_description(), *state));
  if (motion_watch_ && doubts_.doubts_readback()) {
    motion_watch_->released();
  } else if (motion_watch_ && motion_watch_->orders() == orders) {
    auto looking = look_for_motion(*state);
    co_await std::move(looking);
  }
  co_return state;
}

// A readback that is false is the doubts' matter: the axes have not moved when the instruments say
// that they are where they should be.
Awaitable<void> DeviceBench::look_for_motion(MotionState state) {
  const auto before = *motion_watch_;
  const auto moved = motion_watch_->look(state);
  if (!moved) co_return;
  auto asking = instruments_say_(before.expected_mm());
  const bool are_there = co_await std::move(asking);
  if (!are_there) co_return on_uncommanded_(*moved);
  if (motion_watch_->orders() == before.orders()) *motion_watch_ = before;
}

void DeviceBench::watch_motion(double limit_nm,
                               std::function<Awaitable<bool>(std::vector<double>)> instruments_say,
                               std::function<void(const std::string&)> on_uncommanded) {
  if (!controller_) return;
  instruments_say_ = std::move(instruments_say);
  std::vector<Channel> motors;
  for (const auto& axis : controller_->device->description().axes) motors.push_back(axis.channel);
  motion_watch_.emplace(std::move(motors), limit_nm);
  on_uncommanded_ = std::move(on_uncommanded);
}

Awaitable<Result<void>> DeviceBench::home() {
  if (!controller_) co_return tl::unexpected(no_controller());
  if (motion_watch_) motion_watch_->released();
  auto homed = co_await ask_to_move(*controller_, [](MotionController& c) { return c.home(); });
  if (motion_watch_) motion_watch_->released();
  doubts_.begin_anew(controller_description().id);
  co_return homed;
}

Awaitable<Result<void>> DeviceBench::start_move(std::vector<double> q_mm) {
  if (!controller_) co_return tl::unexpected(no_controller());
  auto started = co_await ask_to_move(*controller_, [this, &q_mm](MotionController& c) {
    // Before it is sent: a move whose answer got lost may have started all the same.
    if (motion_watch_) motion_watch_->commanded(q_mm);
    return c.start_move(q_mm);
  });
  if (!started && motion_watch_) motion_watch_->released();
  co_return started;
}

Awaitable<Result<void>> DeviceBench::stop() {
  if (!controller_) co_return Result<void>{};
  if (motion_watch_) motion_watch_->released();
  auto stopped = co_await controller_->device->stop();
  if (motion_watch_) motion_watch_->released();
  co_return stopped;
}

Awaitable<Result<JudgedReading>> DeviceBench::read_interferometer(std::size_t i) {
  co_return co_await read_judged(*interferometers_.at(i));
}
Awaitable<Result<JudgedReading>> DeviceBench::read_collimator(std::size_t i) {
  co_return co_await read_judged(*collimators_.at(i));
}

Awaitable<Result<JudgedReading>> DeviceBench::read_judged(Seat<Instrument>& seat) {
  DRIFTWISE_CO_TRY(auto reading, co_await ask(seat, [](Instrument& d) { return d.read(); }));
  co_return doubts_.judge(std::move(reading));
}

Awaitable<void> DeviceBench::read_into(Seat<Instrument>& seat,
                                       std::optional<Result<JudgedReading>>& place) {
  auto reading = co_await read_judged(seat);
  place.emplace(std::move(reading));
}

Awaitable<Result<std::vector<JudgedReading>>> DeviceBench::read_pose_instruments() {
  std::vector<Seat<Instrument>*> seats;
  for (auto& seat : interferometers_) seats.push_back(seat.get());
  for (auto& seat : collimators_) seats.push_back(seat.get());
  const auto executor = co_await asio::this_coro::executor;
  TaskGroup under_way(executor);
  std::vector<std::optional<Result<JudgedReading>>> answers(seats.size());
  for (std::size_t i = 0; i < seats.size(); ++i) {
    under_way.spawn(read_into(*seats[i], answers[i]));
  }
  co_await under_way.all_ended();
  std::vector<JudgedReading> readings;
  for (auto& answer : answers) {
    if (!*answer) co_return tl::unexpected(answer->error());
    readings.push_back(std::move(**answer));
  }
  co_return readings;
}

Awaitable<Result<void>> DeviceBench::zero_interferometer(std::size_t i) {
  auto zeroed = co_await ask(*interferometers_.at(i), [](Instrument& d) { return d.zero(); });
  doubts_.begin_anew(interferometer_description(i).id);
  co_return zeroed;
}
Awaitable<Result<JudgedReading>> DeviceBench::read_scanner(std::size_t i) {
  co_return co_await read_judged(*scanners_.at(i));
}
Awaitable<Result<JudgedReading>> DeviceBench::read_stabiliser(std::size_t i) {
  DRIFTWISE_CO_TRY(auto reading,
                   co_await ask(*stabilisers_.at(i), [](Stabiliser& d) { return d.read(); }));
  co_return doubts_.judge(std::move(reading));
}
Awaitable<Result<void>> DeviceBench::set_stabiliser(std::size_t i, double degc) {
  co_return co_await ask(*stabilisers_.at(i), [degc](Stabiliser& d) { return d.set_point(degc); });
}

Awaitable<Result<LoadState>> DeviceBench::load_state() {
  auto state = co_await ask(*load_, [](LoadActuator& d) { return d.state(); });
  if (!state) co_return state;
  const auto reading = doubts_.judged(load_description(), *state, load_sequence_);
  if (!reading.rejected.empty())
    co_return fail(ErrorCode::failed_precondition, reasons::kImplausible,
                   reading.rejected.front().reason);
  co_return state;
}
Awaitable<Result<void>> DeviceBench::set_load(double force_n) {
  auto set =
      co_await ask_to_move(*load_, [force_n](LoadActuator& d) { return d.set_force(force_n); });
  doubts_.begin_anew(load_description().id);
  co_return set;
}
Awaitable<Result<JudgedReading>> DeviceBench::read_load() {
  DRIFTWISE_CO_TRY(const auto state,
                   co_await ask(*load_, [](LoadActuator& d) { return d.state(); }));
  co_return doubts_.judged(load_description(), state, ++load_sequence_);
}

const DeviceDescription& DeviceBench::controller_description() const {
  return controller_->device->description();
}
const DeviceDescription& DeviceBench::interferometer_description(std::size_t i) const {
  return interferometers_.at(i)->device->description();
}
const DeviceDescription& DeviceBench::collimator_description(std::size_t i) const {
  return collimators_.at(i)->device->description();
}
const DeviceDescription& DeviceBench::load_description() const {
  return load_->device->description();
}
const DeviceDescription& DeviceBench::scanner_description(std::size_t i) const {
  return scanners_.at(i)->device->description();
}
const DeviceDescription& DeviceBench::stabiliser_description(std::size_t i) const {
  return stabilisers_.at(i)->device->description();
}

Awaitable<Result<void>> DeviceBench::prepare_for_run() {
  if (!controller_) co_return tl::unexpected(no_controller());
  if (auto ok = co_await ask(*controller_, [](MotionController& c) { return c.prepare(); }); !ok)
    co_return ok;
  for (auto& seat : interferometers_)
    if (auto ok = co_await ask(*seat, [](Instrument& d) { return d.prepare(); }); !ok) co_return ok;
  for (auto& seat : collimators_)
    if (auto ok = co_await ask(*seat, [](Instrument& d) { return d.prepare(); }); !ok) co_return ok;
  for (auto& seat : scanners_)
    if (auto ok = co_await ask(*seat, [](Instrument& d) { return d.prepare(); }); !ok) co_return ok;
  if (load_)
    if (auto ok = co_await ask(*load_, [](LoadActuator& d) { return d.prepare(); }); !ok)
      co_return ok;
  for (auto& seat : stabilisers_)
    if (auto ok = co_await ask(*seat, [](Stabiliser& d) { return d.prepare(); }); !ok) co_return ok;
  co_return Result<void>{};
}

template <class Visit>
void DeviceBench::for_each_seat(Visit visit) const {
  if (controller_) visit(*controller_);
  for (const auto& seat : interferometers_) visit(*seat);
  for (const auto& seat : collimators_) visit(*seat);
  for (const auto& seat : scanners_) visit(*seat);
  for (const auto& seat : stabilisers_) visit(*seat);
  if (load_) visit(*load_);
}

Awaitable<Result<void>> DeviceBench::prepare(std::size_t device) {
  std::optional<Awaitable<Result<void>>> asking;
  std::size_t at = 0;
  for_each_seat([this, device, &at, &asking](auto& seat) {
    if (at++ == device) asking = ask(seat, [](auto& d) { return d.prepare(); });
  });
  if (!asking) co_return Result<void>{};
  co_return co_await std::move(*asking);
}

std::vector<DeviceStatus> DeviceBench::status() const {
  std::vector<DeviceStatus> all;
  for_each_seat([&all](const auto& seat) {
    all.push_back({seat.device->description(), seat.device->health()});
    // Between two attempts a link connects, and one with garbled answers stands: until it answers,
    // a lost device is a failed one wherever it is shown.
    if (seat.lost) all.back().health.link = LinkState::failed;
  });
  return all;
}

std::vector<std::string> DeviceBench::lost() const {
  std::vector<std::string> ids;
  for_each_seat([&ids](const auto& seat) {
    if (seat.lost) ids.push_back(seat.device->description().id);
  });
  return ids;
}

void DeviceBench::close_all() {
  for_each_seat([](const auto& seat) { seat.device->close(); });
}

}  // namespace driftwise::application
