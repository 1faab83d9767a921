#include "server/application/recording/device_bench.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "server/application/plumbing/task_group.h"
#include "server/application/recording/doubts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

Error no_controller() {
  return {ErrorCode::failed_precondition, reasons::kNoController,
          "this cell has no motion controller: add one to the cell file"};
}

template <class... Visits>
struct Overloaded : Visits... {
  using Visits::operator()...;
};

}  // namespace

bool is_device_loss(const Error& error) {
  return error.code == ErrorCode::unavailable || error.code == ErrorCode::deadline_exceeded ||
         error.code == ErrorCode::data_loss;
}

DeviceBench::DeviceBench(asio::any_io_executor executor, Devices devices, Doubts& doubts,
                         OnChange on_change)
    : doubts_(doubts), on_change_(std::move(on_change)) {
  for (auto& made : devices) slots_.push_back(std::make_unique<Slot>(executor, std::move(made)));
  std::ranges::stable_sort(slots_, {}, [](const auto& slot) { return slot->description().role(); });
  use(nullptr);
}

void DeviceBench::use(const SetupDescription* setup) {
  setup_ = setup;
  for (auto& numbers : by_role_) numbers.clear();
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const auto& device = description(i);
    const bool is_left_out =
        setup && measures_pose(device.role()) &&
        std::ranges::find(setup->coordinates, device.id, &SetupCoordinate::device) ==
            setup->coordinates.end();
    if (!is_left_out) by_role_[static_cast<std::size_t>(device.role())].push_back(i);
  }
}

bool DeviceBench::may_be_lost(std::size_t device) const {
  return setup_ && std::ranges::all_of(setup_->coordinates, [&](const auto& coordinate) {
           return coordinate.device != description(device).id || coordinate.may_be_missing();
         });
}

DeviceBench::~DeviceBench() = default;

const DeviceDescription& DeviceBench::description(std::size_t device) const {
  return slots_.at(device)->description();
}

template <class R>
void DeviceBench::note(Slot& slot, const R& result) {
  // One garbled answer is an error on record (health), not a lost device; no answer at all is one.
  constexpr int kGarbledInARow = 3;
  if (result || !is_device_loss(result.error())) {
    slot.failures = 0;
    if (std::exchange(slot.lost, false)) on_change_(slot.description(), nullptr);
    return;
  }
  ++slot.failures;
  const bool is_lost =
      result.error().code != ErrorCode::data_loss || slot.failures >= kGarbledInARow;
  if (is_lost && !std::exchange(slot.lost, true)) on_change_(slot.description(), &result.error());
}

template <class Port, class Call>
auto DeviceBench::ask(Slot& slot, Port& port, Call call) -> std::invoke_result_t<Call, Port&> {
  const auto lock = co_await slot.mutex.lock();
  auto result = co_await call(port);
  note(slot, result);
  co_return result;
}

// The lock may have been waited for: what forbids the motion may be younger than the request.
template <class Port, class Call>
Awaitable<Result<void>> DeviceBench::ask_to_move(Slot& slot, Port& port, Call call) {
  const auto lock = co_await slot.mutex.lock();
  if (auto allowed = gate_(); !allowed) co_return allowed;
  auto result = co_await call(port);
  note(slot, result);
  co_return result;
}

Awaitable<Result<JudgedReading>> DeviceBench::read(std::size_t device) {
  Slot& slot = *slots_.at(device);
  return std::visit(
      Overloaded{
          [&](const std::unique_ptr<Instrument>& one) { return read_instrument(slot, *one); },
          [&](const std::unique_ptr<Stabiliser>& one) { return read_stabiliser(slot, *one); },
          [&](const std::unique_ptr<MotionController>&) { return read_axes(slot, device); },
          [&](const std::unique_ptr<LoadActuator>& one) { return read_load(slot, *one); }},
      slot.made.port);
}

Awaitable<Result<JudgedReading>> DeviceBench::read_instrument(Slot& slot, Instrument& instrument) {
  DRIFTWISE_CO_TRY(auto reading,
                   co_await ask(slot, instrument, [](Instrument& d) { return d.read(); }));
  co_return doubts_.judge(std::move(reading));
}

Awaitable<Result<JudgedReading>> DeviceBench::read_stabiliser(Slot& slot, Stabiliser& stabiliser) {
  DRIFTWISE_CO_TRY(auto reading,
                   co_await ask(slot, stabiliser, [](Stabiliser& d) { return d.read(); }));
  co_return doubts_.judge(std::move(reading));
}

// Axis positions as a reading of the controller.
Awaitable<Result<JudgedReading>> DeviceBench::read_axes(Slot& slot, std::size_t device) {
  DRIFTWISE_CO_TRY(const auto state, co_await motion_state(device));
  const auto& axes = slot.description().axes();
  Reading reading{slot.description().id, state.at, state.at, ++slot.sequence, {}};
  for (std::size_t i = 0; i < std::min(axes.size(), state.q_mm.size()); ++i)
    reading.values.push_back({axes[i].channel.name(), state.q_mm[i]});
  co_return JudgedReading{std::move(reading), {}};
}

// The force; missing while weights move.
Awaitable<Result<JudgedReading>> DeviceBench::read_load(Slot& slot, LoadActuator& actuator) {
  DRIFTWISE_CO_TRY(const auto state,
                   co_await ask(slot, actuator, [](LoadActuator& d) { return d.state(); }));
  co_return doubts_.judged(slot.description(), state, ++slot.sequence);
}

Awaitable<void> DeviceBench::read_into(std::size_t device,
                                       std::optional<Result<JudgedReading>>& place) {
  auto reading = co_await read(device);
  place.emplace(std::move(reading));
}

Awaitable<Result<std::vector<JudgedReading>>> DeviceBench::read_pose_instruments(bool at_zero) {
  std::vector<std::size_t> asked = with_role(DeviceRole::length);
  std::ranges::copy(with_role(DeviceRole::angle), std::back_inserter(asked));
  const auto executor = co_await asio::this_coro::executor;
  TaskGroup under_way(executor);
  std::vector<std::optional<Result<JudgedReading>>> answers(asked.size());
  for (std::size_t i = 0; i < asked.size(); ++i) {
    under_way.spawn(read_into(asked[i], answers[i]));
  }
  co_await under_way.all_ended();
  std::vector<JudgedReading> readings;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    auto& answer = *answers[i];
    const bool is_out_of_sight = !answer && (answer.error().reason == reasons::kBeamLost ||
                                             answer.error().reason == reasons::kNoSpot);
    if (is_out_of_sight && !at_zero && may_be_lost(asked[i])) continue;
    DRIFTWISE_CO_RETURN_IF_ERROR(answer);
    readings.push_back(std::move(*answer));
  }
  co_return readings;
}

Awaitable<Result<void>> DeviceBench::zero(std::size_t device) {
  Slot& slot = *slots_.at(device);
  auto zeroed =
      co_await ask(slot, *slot.made.as<Instrument>(), [](Instrument& d) { return d.zero(); });
  doubts_.begin_anew(slot.description().id);
  co_return zeroed;
}

Awaitable<Result<void>> DeviceBench::set_point(std::size_t device, double degc) {
  Slot& slot = *slots_.at(device);
  co_return co_await ask(slot, *slot.made.as<Stabiliser>(),
                         [degc](Stabiliser& d) { return d.set_point(degc); });
}

DeviceBench::Slot* DeviceBench::controller() {
  return has(DeviceRole::motion) ? slots_[with_role(DeviceRole::motion).front()].get() : nullptr;
}

const DeviceDescription& DeviceBench::controller_description() const {
  return description(with_role(DeviceRole::motion).front());
}

Awaitable<Result<MotionState>> DeviceBench::motion_state() {
  if (!controller()) co_return tl::unexpected(no_controller());
  co_return co_await motion_state(with_role(DeviceRole::motion).front());
}

Awaitable<Result<MotionState>> DeviceBench::motion_state(std::size_t device) {
  Slot& slot = *slots_.at(device);
  // Only the robot in use is commanded from here, so only its motion can be told from other motion.
  auto* watch = &slot == controller() && motion_watch_ ? &*motion_watch_ : nullptr;
  const auto orders = watch ? watch->orders() : 0;
  auto state = co_await ask(slot, *slot.made.as<MotionController>(),
                            [](MotionController& c) { return c.state(); });
  if (!state) {
    if (watch && is_device_loss(state.error())) watch->lost();
    co_return state;
  }
  DRIFTWISE_CO_RETURN_IF_ERROR(doubts_.judge(slot.description(), *state));
  if (watch && doubts_.doubts_readback()) {
    watch->released();
  } else if (watch && watch->orders() == orders) {
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
  if (!controller()) return;
  instruments_say_ = std::move(instruments_say);
  std::vector<Channel> motors;
  for (const auto& axis : controller_description().axes()) motors.push_back(axis.channel);
  motion_watch_.emplace(std::move(motors), limit_nm);
  on_uncommanded_ = std::move(on_uncommanded);
}

Awaitable<Result<void>> DeviceBench::home() {
  Slot* slot = controller();
  if (!slot) co_return tl::unexpected(no_controller());
  if (motion_watch_) motion_watch_->released();
  auto homed = co_await ask_to_move(*slot, *slot->made.as<MotionController>(),
                                    [](MotionController& c) { return c.home(); });
  if (motion_watch_) motion_watch_->released();
  doubts_.begin_anew(slot->description().id);
  co_return homed;
}

Awaitable<Result<void>> DeviceBench::start_move(std::vector<double> q_mm) {
  Slot* slot = controller();
  if (!slot) co_return tl::unexpected(no_controller());
  auto started = co_await ask_to_move(*slot, *slot->made.as<MotionController>(),
                                      [this, &q_mm](MotionController& c) {
                                        // Before it is sent: a move whose answer got lost may have
                                        // started all the same.
                                        if (motion_watch_) motion_watch_->commanded(q_mm);
                                        return c.start_move(q_mm);
                                      });
  if (!started && motion_watch_) motion_watch_->released();
  co_return started;
}

Awaitable<Result<void>> DeviceBench::stop() {
  Result<void> all;
  for (const auto device : with_role(DeviceRole::motion))
    if (auto stopped = co_await stop(device); !stopped && all) all = stopped;
  co_return all;
}

Awaitable<Result<void>> DeviceBench::stop(std::size_t device) {
  Slot& slot = *slots_.at(device);
  const bool is_watched = &slot == controller() && motion_watch_;
  if (is_watched) motion_watch_->released();
  auto stopped = co_await slot.made.as<MotionController>()->stop();
  if (is_watched) motion_watch_->released();
  co_return stopped;
}

DeviceBench::Slot& DeviceBench::load() { return *slots_[with_role(DeviceRole::load).front()]; }

const DeviceDescription& DeviceBench::load_description() const {
  return description(with_role(DeviceRole::load).front());
}

Awaitable<Result<LoadState>> DeviceBench::load_state() {
  Slot& slot = load();
  auto state =
      co_await ask(slot, *slot.made.as<LoadActuator>(), [](LoadActuator& d) { return d.state(); });
  if (!state) co_return state;
  const auto reading = doubts_.judged(slot.description(), *state, slot.sequence);
  if (!reading.rejected.empty())
    co_return fail(ErrorCode::failed_precondition, reasons::kImplausible,
                   reading.rejected.front().reason);
  co_return state;
}

Awaitable<Result<void>> DeviceBench::set_load(double force_n) {
  Slot& slot = load();
  auto set = co_await ask_to_move(slot, *slot.made.as<LoadActuator>(),
                                  [force_n](LoadActuator& d) { return d.set_force(force_n); });
  doubts_.begin_anew(slot.description().id);
  co_return set;
}

Awaitable<Result<void>> DeviceBench::prepare_for_run() {
  if (!controller()) co_return tl::unexpected(no_controller());
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const auto& in_use = with_role(description(i).role());
    if (std::ranges::find(in_use, i) != in_use.end())
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await prepare(i));
  }
  co_return Result<void>{};
}

Awaitable<Result<void>> DeviceBench::prepare(std::size_t device) {
  if (device >= slots_.size()) co_return Result<void>{};
  Slot& slot = *slots_[device];
  co_return co_await ask(slot, slot.made.device(), [](Device& d) { return d.prepare(); });
}

std::vector<DeviceStatus> DeviceBench::status() const {
  std::vector<DeviceStatus> all;
  for (const auto& slot : slots_) {
    all.push_back({slot->description(), slot->made.device().health()});
    // Between two attempts a link connects, and one with garbled answers stands: until it answers,
    // a lost device is a failed one wherever it is shown.
    if (slot->lost) all.back().health.link = LinkState::failed;
  }
  return all;
}

std::vector<std::string> DeviceBench::lost() const {
  std::vector<std::string> ids;
  for (const auto& slot : slots_)
    if (slot->lost) ids.push_back(slot->description().id);
  return ids;
}

void DeviceBench::close_all() {
  for (const auto& slot : slots_) slot->made.device().close();
}

}  // namespace driftwise::application
