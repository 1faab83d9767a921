#include "server/application/recording/device_bench.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/application/plumbing/task_group.h"
#include "server/application/recording/doubts.h"
#include "server/core/ports/control/axis_follower.h"
#include "server/core/ports/control/tunable_loop.h"
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

DeviceBench::DeviceBench(asio::any_io_executor executor, Devices devices, Doubts& doubts,
                         OnChange on_change)
    : doubts_(doubts), on_change_(std::move(on_change)) {
  for (auto& made : devices) slots_.push_back(std::make_unique<Slot>(executor, std::move(made)));
  std::ranges::stable_sort(slots_, {}, [](const auto& slot) { return slot->description().role(); });
  use(nullptr);
  std::size_t axes = 0;
  for (auto* slot : controllers()) {
    slot->first_axis = axes;
    axes += slot->description().axes().size();
  }
}

void DeviceBench::use(const SetupDescription* setup) {
  setup_.use(setup);
  for (auto& numbers : by_role_) numbers.clear();
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const auto& device = description(i);
    if (!setup_.leaves_out(device)) by_role_[static_cast<std::size_t>(device.role())].push_back(i);
  }
}

DeviceBench::~DeviceBench() = default;

const DeviceDescription& DeviceBench::description(std::size_t device) const {
  return slots_.at(device)->description();
}

template <class R>
void DeviceBench::note(Slot& slot, const R& result) {
  // One garbled answer is an error on record (health), not a lost device; no answer at all is one.
  constexpr int kGarbledInARow = 3;
  if (!result && is_no_answer(result.error())) return;
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
  co_return doubts_.judge(setup_.under_confirming_names(std::move(reading)));
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
    if (is_out_of_sight && !at_zero && setup_.may_lose(description(asked[i]).id)) continue;
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

bool DeviceBench::knows_zeros() const {
  return std::ranges::all_of(with_role(DeviceRole::length), [this](std::size_t device) {
    return slots_[device]->made.as<Instrument>()->knows_its_zero();
  });
}

namespace {

// nullptr: its controller does not tell its parameters.
TunableLoop* loop_of(Device& device) { return dynamic_cast<TunableLoop*>(&device); }

Error no_loop(const DeviceDescription& device) {
  return {ErrorCode::failed_precondition, reasons::kNoStabiliser,
          "the controller of '" + device.id + "' does not tell its control parameters"};
}

}  // namespace

LoopTuning DeviceBench::declared_tuning(std::size_t device) const {
  const auto* loop = loop_of(slots_.at(device)->made.device());
  return loop ? loop->declared_tuning() : LoopTuning{};
}

Awaitable<Result<LoopTuning>> DeviceBench::tuning(std::size_t device) {
  Slot& slot = *slots_.at(device);
  auto* loop = loop_of(slot.made.device());
  if (!loop) co_return tl::unexpected(no_loop(slot.description()));
  co_return co_await ask(slot, *loop, [](TunableLoop& d) { return d.tuning(); });
}

Awaitable<Result<LoopTuning>> DeviceBench::set_tuning(std::size_t device, LoopTuning wanted) {
  Slot& slot = *slots_.at(device);
  auto* loop = loop_of(slot.made.device());
  if (!loop) co_return tl::unexpected(no_loop(slot.description()));
  co_return co_await ask(slot, *loop, [wanted](TunableLoop& d) { return d.set_tuning(wanted); });
}

Awaitable<Result<void>> DeviceBench::set_point(std::size_t device, double degc) {
  Slot& slot = *slots_.at(device);
  co_return co_await ask(slot, *slot.made.as<Stabiliser>(),
                         [degc](Stabiliser& d) { return d.set_point(degc); });
}

std::vector<DeviceBench::Slot*> DeviceBench::controllers() {
  std::vector<Slot*> all;
  for (const auto device : with_role(DeviceRole::motion)) all.push_back(slots_[device].get());
  return all;
}

Awaitable<Result<MotionState>> DeviceBench::motion_state() {
  DRIFTWISE_CO_TRY(auto states, co_await motion_states());
  MotionState all = std::move(states.front());
  for (std::size_t i = 1; i < states.size(); ++i) all.join(states[i]);
  co_return all;
}

Awaitable<Result<std::vector<MotionState>>> DeviceBench::motion_states() {
  const auto asked = controllers();
  if (asked.empty()) co_return tl::unexpected(no_controller());
  std::vector<std::optional<Result<MotionState>>> answers(asked.size());
  if (asked.size() == 1) {
    auto answer = co_await motion_state(*asked.front());
    answers.front().emplace(std::move(answer));
  } else {
    TaskGroup under_way(co_await asio::this_coro::executor);
    for (std::size_t i = 0; i < asked.size(); ++i)
      under_way.spawn(state_into(*asked[i], answers[i]));
    co_await under_way.all_ended();
  }
  std::vector<MotionState> states;
  const Error* trouble = nullptr;
  for (const auto& answer : answers) {
    if (!*answer && !trouble) trouble = &answer->error();
    if (*answer) states.push_back(**answer);
  }
  if (!trouble) co_return states;
  // Motion beside a robot that cannot be asked is not known to be safe.
  for (std::size_t i = 0; i < asked.size(); ++i)
    if (*answers[i] && (*answers[i])->moving) static_cast<void>(co_await stop_one(*asked[i]));
  co_return tl::unexpected(*trouble);
}

Awaitable<void> DeviceBench::state_into(Slot& slot, std::optional<Result<MotionState>>& place) {
  auto state = co_await motion_state(slot);
  place.emplace(std::move(state));
}

Awaitable<Result<MotionState>> DeviceBench::motion_state(std::size_t device) {
  return motion_state(*slots_.at(device));
}

Awaitable<Result<MotionState>> DeviceBench::motion_state(Slot& slot) {
  auto* watch = slot.watch ? &*slot.watch : nullptr;
  const auto orders = watch ? watch->orders() : 0;
  auto state = co_await ask(slot, *slot.made.as<MotionController>(),
                            [](MotionController& c) { return c.state(); });
  if (!state) {
    if (is_device_loss(state.error())) tell_followers(slot.description(), {});
    if (watch && is_device_loss(state.error())) watch->lost();
    co_return state;
  }
  DRIFTWISE_CO_RETURN_IF_ERROR(doubts_.judge(slot.description(), *state));
  slot.last_q_mm = state->q_mm;
  const bool is_known = state->referenced && !doubts_.doubts_readback();
  tell_followers(slot.description(), is_known ? state->q_mm : std::vector<double>{});
  if (watch && doubts_.doubts_readback()) {
    watch->released();
  } else if (watch && watch->orders() == orders) {
    auto looking = look_for_motion(slot, *state);
    co_await std::move(looking);
  }
  co_return state;
}

void DeviceBench::tell_followers(const DeviceDescription& controller,
                                 const std::vector<double>& q_mm) {
  const auto& axes = controller.axes();
  for (const auto& slot : slots_) {
    auto* follower = dynamic_cast<AxisFollower*>(&slot->made.device());
    if (follower == nullptr) continue;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      if (axes[i].channel != follower->followed_axis()) continue;
      if (i < q_mm.size())
        follower->axis_at(q_mm[i]);
      else
        follower->axis_unknown();
    }
  }
}

void DeviceBench::release(Slot& slot) {
  if (slot.watch) slot.watch->released();
  tell_followers(slot.description(), {});
}

// Commanded places of all axes of the cell; of an axis without one, as read back last.
std::vector<double> DeviceBench::expected_mm(const Slot& looked_at, const MotionWatch& before) {
  std::vector<double> q_mm;
  for (const auto* slot : controllers()) {
    const auto* watch = slot == &looked_at ? &before : slot->watch ? &*slot->watch : nullptr;
    const auto& one =
        watch && !watch->expected_mm().empty() ? watch->expected_mm() : slot->last_q_mm;
    q_mm.insert(q_mm.end(), one.begin(), one.end());
  }
  return q_mm;
}

// A readback that is false is the doubts' matter: the axes have not moved when the instruments say
// that they are where they should be.
Awaitable<void> DeviceBench::look_for_motion(Slot& slot, MotionState state) {
  const auto before = *slot.watch;
  const auto moved = slot.watch->look(state);
  if (!moved) co_return;
  // A statement of the controller about itself needs no second witness.
  if (moved->kind != MotionFinding::Kind::moved) co_return on_uncommanded_(*moved);
  auto asking = instruments_say_(expected_mm(slot, before));
  const bool are_there = co_await std::move(asking);
  if (!are_there) co_return on_uncommanded_(*moved);
  if (slot.watch->orders() == before.orders()) *slot.watch = before;
}

void DeviceBench::watch_motion(double limit_nm,
                               std::function<Awaitable<bool>(std::vector<double>)> instruments_say,
                               std::function<void(const MotionFinding&)> on_uncommanded) {
  instruments_say_ = std::move(instruments_say);
  on_uncommanded_ = std::move(on_uncommanded);
  for (auto* slot : controllers()) {
    std::vector<Channel> motors;
    for (const auto& axis : slot->description().axes()) motors.push_back(axis.channel);
    slot->watch.emplace(std::move(motors), limit_nm);
  }
}

Awaitable<Result<void>> DeviceBench::home() {
  const auto all = controllers();
  if (all.empty()) co_return tl::unexpected(no_controller());
  for (auto* slot : all) DRIFTWISE_CO_RETURN_IF_ERROR(co_await home_one(*slot));
  co_return Result<void>{};
}

Awaitable<Result<void>> DeviceBench::home_one(Slot& slot) {
  release(slot);
  auto homed = co_await ask_to_move(slot, *slot.made.as<MotionController>(),
                                    [](MotionController& c) { return c.home(); });
  release(slot);
  doubts_.begin_anew(slot.description().id);
  co_return homed;
}

Awaitable<Result<void>> DeviceBench::start_move(std::vector<double> q_mm, AxesToMove moved) {
  const auto all = controllers();
  if (all.empty()) co_return tl::unexpected(no_controller());
  if (all.size() == 1) co_return co_await move_one(*all.front(), std::move(q_mm));
  std::vector<Slot*> told;
  std::vector<std::vector<double>> parts;
  for (auto* slot : all) {
    const auto first = slot->first_axis, count = slot->description().axes().size();
    bool is_meant = false;
    for (std::size_t i = first; i < first + count; ++i) is_meant = is_meant || moved.contains(i);
    if (!is_meant || first + count > q_mm.size()) continue;
    told.push_back(slot);
    const auto begin = q_mm.begin() + static_cast<std::ptrdiff_t>(first);
    parts.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(count));
  }
  std::vector<std::optional<Result<void>>> answers(told.size());
  TaskGroup under_way(co_await asio::this_coro::executor);
  for (std::size_t i = 0; i < told.size(); ++i)
    under_way.spawn(move_into(*told[i], parts[i], answers[i]));
  co_await under_way.all_ended();
  Result<void> first_trouble;
  for (const auto& answer : answers)
    if (!*answer && first_trouble) first_trouble = *answer;
  if (!first_trouble)
    for (std::size_t i = 0; i < told.size(); ++i)
      if (*answers[i]) static_cast<void>(co_await stop_one(*told[i]));
  co_return first_trouble;
}

Awaitable<Result<void>> DeviceBench::move_one(Slot& slot, std::vector<double> q_mm) {
  auto started = co_await ask_to_move(slot, *slot.made.as<MotionController>(),
                                      [&slot, &q_mm](MotionController& c) {
                                        // Before it is sent: a move whose answer got lost may have
                                        // started all the same.
                                        if (slot.watch) slot.watch->commanded(q_mm);
                                        return c.start_move(q_mm);
                                      });
  if (!started) release(slot);
  co_return started;
}

Awaitable<void> DeviceBench::move_into(Slot& slot, std::vector<double> q_mm,
                                       std::optional<Result<void>>& place) {
  auto started = co_await move_one(slot, std::move(q_mm));
  place.emplace(std::move(started));
}

Awaitable<Result<void>> DeviceBench::stop() {
  const auto all = controllers();
  if (all.size() == 1) co_return co_await stop_one(*all.front());
  std::vector<std::optional<Result<void>>> answers(all.size());
  TaskGroup under_way(co_await asio::this_coro::executor);
  for (std::size_t i = 0; i < all.size(); ++i) under_way.spawn(stop_into(*all[i], answers[i]));
  co_await under_way.all_ended();
  for (const auto& answer : answers)
    if (!*answer) co_return *answer;
  co_return Result<void>{};
}

Awaitable<Result<void>> DeviceBench::stop(std::size_t device) {
  return stop_one(*slots_.at(device));
}

Awaitable<Result<void>> DeviceBench::stop_one(Slot& slot) {
  release(slot);
  auto stopped = co_await slot.made.as<MotionController>()->stop();
  release(slot);
  co_return stopped;
}

Awaitable<void> DeviceBench::stop_into(Slot& slot, std::optional<Result<void>>& place) {
  auto stopped = co_await stop_one(slot);
  place.emplace(std::move(stopped));
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
  if (!has(DeviceRole::motion)) co_return tl::unexpected(no_controller());
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
  const auto lock = co_await slot.mutex.lock();
  auto prepared = co_await slot.made.device().prepare();
  // An identity says nothing of the data: a device that gave none is back when it gives some.
  if (!prepared || slot.failures == 0) note(slot, prepared);
  co_return prepared;
}

std::vector<DeviceStatus> DeviceBench::status() const {
  std::vector<DeviceStatus> all;
  for (const auto& slot : slots_) {
    all.push_back({slot->description(), slot->made.device().health(),
                   setup_.leaves_out(slot->description())});
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
