#include "server/application/device_bench.h"

#include <utility>

namespace driftwise::application {

bool is_device_loss(const Error& error) {
  return error.code == ErrorCode::unavailable || error.code == ErrorCode::deadline_exceeded ||
         error.code == ErrorCode::data_loss;
}

DeviceBench::DeviceBench(asio::any_io_executor executor, Devices devices, OnChange on_change)
    : on_change_(std::move(on_change)) {
  if (devices.controller)
    controller_ = std::make_unique<Seat<MotionController>>(executor, std::move(devices.controller));
  for (auto& d : devices.interferometers)
    interferometers_.push_back(std::make_unique<Seat<Instrument>>(executor, std::move(d)));
  for (auto& d : devices.scanners)
    scanners_.push_back(std::make_unique<Seat<Instrument>>(executor, std::move(d)));
  for (auto& d : devices.stabilisers)
    stabilisers_.push_back(std::make_unique<Seat<Stabiliser>>(executor, std::move(d)));
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
  const auto held = co_await seat.turn.take();
  auto result = co_await call(*seat.device);
  note(seat, result);
  co_return result;
}

namespace {
// Plain functions of the port: a lambda without captures may be a coroutine's caller, its frame
// holds only arguments.
Error no_controller() {
  return {ErrorCode::failed_precondition, "NO_CONTROLLER",
          "this cell has no motion controller: add one to the cell file"};
}
}  // namespace

Awaitable<Result<MotionState>> DeviceBench::motion_state() {
  if (!controller_) co_return tl::unexpected(no_controller());
  co_return co_await ask(*controller_, [](MotionController& c) { return c.state(); });
}

Awaitable<Result<void>> DeviceBench::home() {
  if (!controller_) co_return tl::unexpected(no_controller());
  co_return co_await ask(*controller_, [](MotionController& c) { return c.home(); });
}

Awaitable<Result<void>> DeviceBench::start_move(std::vector<double> q_mm) {
  if (!controller_) co_return tl::unexpected(no_controller());
  co_return co_await ask(*controller_, [&q_mm](MotionController& c) { return c.start_move(q_mm); });
}

Awaitable<Result<void>> DeviceBench::stop() {
  if (!controller_) co_return Result<void>{};
  co_return co_await controller_->device->stop();
}

Awaitable<Result<Reading>> DeviceBench::read_interferometer(std::size_t i) {
  co_return co_await ask(*interferometers_.at(i), [](Instrument& d) { return d.read(); });
}
Awaitable<Result<void>> DeviceBench::zero_interferometer(std::size_t i) {
  co_return co_await ask(*interferometers_.at(i), [](Instrument& d) { return d.zero(); });
}
Awaitable<Result<Reading>> DeviceBench::read_scanner(std::size_t i) {
  co_return co_await ask(*scanners_.at(i), [](Instrument& d) { return d.read(); });
}
Awaitable<Result<Reading>> DeviceBench::read_stabiliser(std::size_t i) {
  co_return co_await ask(*stabilisers_.at(i), [](Stabiliser& d) { return d.read(); });
}
Awaitable<Result<void>> DeviceBench::set_stabiliser(std::size_t i, double degc) {
  co_return co_await ask(*stabilisers_.at(i), [degc](Stabiliser& d) { return d.set_point(degc); });
}

const DeviceDescription& DeviceBench::controller_description() const {
  return controller_->device->description();
}
const DeviceDescription& DeviceBench::interferometer_description(std::size_t i) const {
  return interferometers_.at(i)->device->description();
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
  for (auto& seat : scanners_)
    if (auto ok = co_await ask(*seat, [](Instrument& d) { return d.prepare(); }); !ok) co_return ok;
  for (auto& seat : stabilisers_)
    if (auto ok = co_await ask(*seat, [](Stabiliser& d) { return d.prepare(); }); !ok) co_return ok;
  co_return Result<void>{};
}

namespace {
template <class F, class C, class I, class S>
void for_each_seat(C& controller, I& interferometers, I& scanners, S& stabilisers, F f) {
  if (controller) f(*controller);
  for (auto& seat : interferometers) f(*seat);
  for (auto& seat : scanners) f(*seat);
  for (auto& seat : stabilisers) f(*seat);
}
}  // namespace

std::vector<DeviceStatus> DeviceBench::status() const {
  std::vector<DeviceStatus> all;
  for_each_seat(controller_, interferometers_, scanners_, stabilisers_, [&all](const auto& seat) {
    all.push_back({seat.device->description(), seat.device->health()});
  });
  return all;
}

std::vector<std::string> DeviceBench::lost() const {
  std::vector<std::string> ids;
  for_each_seat(controller_, interferometers_, scanners_, stabilisers_, [&ids](const auto& seat) {
    if (seat.lost) ids.push_back(seat.device->description().id);
  });
  return ids;
}

void DeviceBench::close_all() {
  for_each_seat(controller_, interferometers_, scanners_, stabilisers_,
                [](const auto& seat) { seat.device->close(); });
}

}  // namespace driftwise::application
