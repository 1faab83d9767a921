#include "tests/support/small_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "server/core/ports/control/tunable_loop.h"
#include "server/core/try.h"

namespace driftwise::tests {
namespace {

constexpr double kMmPerNm = 1e-6;
constexpr int kThermometers = 5;  // a point then has twelve channels, as the issue counts them

template <class Port>
class Simulated : public Port {
 public:
  Simulated(SmallWorld& world, VirtualTime& time, DeviceDescription description, bool& away)
      : world_(world), time_(time), description_(std::move(description)), away_(away) {}
  const DeviceDescription& description() const override { return description_; }
  DeviceHealth health() const override {
    DeviceHealth health;
    health.link = away_ ? LinkState::disconnected : LinkState::connected;
    return health;
  }
  Awaitable<Result<void>> prepare() override { co_return co_await answer(0.02); }
  void close() override {}

 protected:
  // Every exchange takes time, and fails while the device is away.
  Awaitable<Result<void>> answer(double seconds) {
    co_await time_.sleep_until(time_.now().utc + nanoseconds_from_s(seconds));
    if (world_.cut) co_return fail(ErrorCode::aborted, "STOPPED", description_.id + ": stopped");
    if (away_)
      co_return fail(ErrorCode::unavailable, "LINK_DOWN",
                     description_.id + " at " + description_.address + ": connection refused");
    co_return Result<void>{};
  }
  double position_mm() const {
    const auto now = time_.now().utc.utc_ns;
    if (now >= world_.move_end_ns) return world_.to_mm;
    const double share = static_cast<double>(now - world_.move_begin_ns) /
                         static_cast<double>(world_.move_end_ns - world_.move_begin_ns);
    return world_.from_mm + share * (world_.to_mm - world_.from_mm);
  }
  double hours() const { return static_cast<double>(time_.now().monotonic_ns) / 3.6e12; }

  SmallWorld& world_;
  VirtualTime& time_;
  DeviceDescription description_;
  bool& away_;
};

class Axis final : public Simulated<MotionController> {
  void halt() {
    if (world_.stop_does_nothing) return;
    world_.from_mm = world_.to_mm = position_mm();
    world_.move_end_ns = 0;
  }

 public:
  using Simulated::Simulated;
  Awaitable<Result<void>> prepare() override {
    ++world_.axis_calls;
    co_return co_await answer(0.02);
  }
  Awaitable<Result<MotionState>> state() override {
    ++world_.axis_calls;
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await answer(0.005));
    const auto now = time_.now().utc;
    const bool moving = now.utc_ns < world_.move_end_ns;
    const double wander_nm =
        world_.creeping ? 400 * std::sin(static_cast<double>(now.utc_ns % 1'000'000'000'000) * 5e-9)
                        : 0;
    const double q = position_mm() + world_.reference_mm +
                     kMmPerNm * (world_.holding_nm * world_.gauss() + wander_nm);
    co_return MotionState{now,
                          {q},
                          moving,
                          world_.referenced,
                          !moving && world_.servo_on,
                          world_.servo_on,
                          world_.halted_at_limit && !moving ? "error 216 (limit switch)" : ""};
  }
  Awaitable<Result<void>> home() override {
    ++world_.axis_calls;
    if (auto ok = co_await answer(3.0); !ok) co_return ok;
    ++world_.homes;
    world_.referenced = world_.servo_on = true;
    world_.halted_at_limit = false;
    world_.reference_mm = kMmPerNm * world_.homing_nm * world_.gauss();
    world_.from_mm = world_.to_mm = -world_.reference_mm;
    world_.move_end_ns = 0;
    co_return Result<void>{};
  }
  Awaitable<Result<void>> start_move(std::span<const double> q_mm) override {
    ++world_.axis_calls;
    const double to_mm = q_mm[0];
    if (auto ok = co_await answer(0.01); !ok) co_return ok;
    if (world_.halted) {
      world_.halted = false;
      co_return fail(ErrorCode::aborted, "STOPPED", "axis: the emergency stop was pressed");
    }
    if (!world_.referenced)
      co_return fail(ErrorCode::failed_precondition, "REFUSED", "axis: error 5, not referenced");
    if (!world_.servo_on)
      co_return fail(ErrorCode::failed_precondition, "SERVO_OFF",
                     "axis: error 5, the servo is off");
    ++world_.moves;
    world_.halted_at_limit = std::exchange(world_.limit_switch, false);
    world_.furthest_mm = std::max(world_.furthest_mm, std::abs(to_mm));
    world_.from_mm = position_mm();
    world_.to_mm = to_mm - world_.reference_mm;
    if (world_.halted_at_limit) world_.to_mm = (world_.from_mm + world_.to_mm) / 2;
    if (std::abs(world_.to_mm - world_.from_mm) > 1e-4)
      world_.came_down = world_.to_mm < world_.from_mm;
    const double seconds = 0.3 + std::abs(world_.to_mm - world_.from_mm) / 4.0;
    world_.move_begin_ns = time_.now().utc.utc_ns;
    world_.move_end_ns = world_.move_begin_ns + nanoseconds_from_s(seconds).count();
    co_return Result<void>{};
  }
  Awaitable<Result<void>> stop() override {
    ++world_.stops;
    ++world_.axis_calls;
    if (world_.first_stop_call == 0) world_.first_stop_call = world_.axis_calls;
    if (!away_) halt();
    auto answered = co_await answer(0.005);
    if (!answered) co_return answered;
    halt();  // the link came back while it was asked
    co_return answered;
  }
};

class Laser final : public Simulated<Instrument> {
 public:
  using Simulated::Simulated;
  DeviceHealth health() const override {
    DeviceHealth health = Simulated::health();
    health.clock_offset = nanoseconds_from_s(world_.laser_clock_s);
    health.clock_jumps = world_.laser_clock_jumps;
    health.last_clock_jump = last_jump_;
    return health;
  }
  Awaitable<Result<Reading>> read() override {
    const auto start = time_.now().utc;
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await answer(0.25));
    if (world_.laser_mute)
      co_return fail(ErrorCode::deadline_exceeded, "NO_ANSWER", "laser-x: no reading within 1 s");
    if (const double jump_s = std::exchange(world_.laser_clock_jump_s, 0); jump_s != 0) {
      world_.laser_clock_s += jump_s;
      ++world_.laser_clock_jumps;
      last_jump_ = nanoseconds_from_s(jump_s);
      co_return fail(ErrorCode::data_loss, "CLOCK_JUMPED", "laser-x: the adapter's clock was set");
    }
    if (world_.beam_lost)
      co_return fail(ErrorCode::failed_precondition, "BEAM_LOST",
                     "laser-x: the beam was lost: zero it");
    ++world_.readings;
    double noise_nm = world_.noise_nm * world_.gauss();
    if (world_.disturbed_readings > 0) {
      --world_.disturbed_readings;
      noise_nm += (world_.disturbed_readings % 2 ? 1 : -1) * world_.disturbance_nm;
    }
    Reading reading{"laser-x", start, time_.now().utc, ++sequence_, {}};
    if (!description_.angles().empty()) {  // ten arcsec for each millimetre
      const double mm = length_mm() + kMmPerNm * noise_nm;
      reading.values = {{description_.angles().front().channel.name(), 10 * mm}};
      co_return reading;
    }
    const auto& length = description_.length()->channel;
    reading.values = {{length.name(), length_mm() + kMmPerNm * noise_nm},
                      {length.symbol + "_std_nm", 2.0},
                      {"air_degC", 20.5 + 0.5 * hours()}};
    co_return reading;
  }
  Awaitable<Result<void>> zero() override {
    if (auto ok = co_await answer(0.1); !ok) co_return ok;
    ++world_.zeroings;
    world_.beam_lost = false;
    world_.zero_mm += length_mm();
    co_return Result<void>{};
  }

 private:
  double length_mm() const {
    const double q_mm = position_mm();
    return q_mm + kMmPerNm * world_.bend_nm_per_mm2 * q_mm * q_mm +
           kMmPerNm * world_.nm_per_k * world_.warming_k_per_h * hours() +
           kMmPerNm * world_.play_nm * (world_.came_down ? 0.5 : -0.5) - world_.zero_mm;
  }
  std::int64_t sequence_ = 0;
  Nanoseconds last_jump_{0};
};

class Scanner final : public Simulated<Instrument> {
 public:
  using Simulated::Simulated;
  Awaitable<Result<Reading>> read() override {
    const auto start = time_.now().utc;
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await answer(1.0));
    ++world_.scans;
    Reading reading{"scanner", start, time_.now().utc, ++sequence_, {}};
    for (int n = 1; n <= kThermometers; ++n) {
      const double degc =
          20 + 0.1 * n + world_.warming_k_per_h * hours() * (n == 1 ? 1.0 : 0.5 / n);
      reading.values.push_back(
          {"t0" + std::to_string(n) + "_degC", n == 3 && world_.probe_broken ? kMissing : degc});
    }
    co_return reading;
  }
  Awaitable<Result<void>> zero() override {
    co_return fail(ErrorCode::failed_precondition, "NO_ZERO", "a scanner has no zero");
  }

 private:
  std::int64_t sequence_ = 0;
};

class Support final : public Simulated<Stabiliser>, public TunableLoop {
 public:
  using Simulated::Simulated;
  Awaitable<Result<Reading>> read() override {
    const auto start = time_.now().utc;
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await answer(0.05));
    // Its loop closes a tenth of the difference with every reading.
    world_.support_degc += 0.1 * (world_.support_set_degc - world_.support_degc);
    Reading reading{"support", start, time_.now().utc, ++sequence_, {}};
    reading.values = {{"support_degC", world_.support_degc},
                      {"support_set_degC", world_.support_set_degc},
                      {"support_power_pct", 20}};
    co_return reading;
  }
  Awaitable<Result<void>> set_point(double degc) override {
    if (auto ok = co_await answer(0.05); !ok) co_return ok;
    world_.support_set_degc = degc;
    co_return Result<void>{};
  }
  LoopTuning declared_tuning() const override { return {}; }
  Awaitable<Result<LoopTuning>> tuning() override {
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await answer(0.05));
    co_return tuning_;
  }
  Awaitable<Result<LoopTuning>> set_tuning(LoopTuning wanted) override {
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await answer(0.05));
    tuning_ = changed(tuning_, wanted);
    co_return tuning_;
  }

 private:
  LoopTuning tuning_{2, 2, 180, 0};
  std::int64_t sequence_ = 0;
};

class Load final : public Simulated<LoadActuator> {
 public:
  using Simulated::Simulated;
  Awaitable<Result<LoadState>> state() override {
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await answer(0.01));
    const auto now = time_.now().utc;
    co_return LoadState{now, world_.force_n, now.utc_ns >= world_.load_rests_at_ns};
  }
  Awaitable<Result<void>> set_force(double force_n) override {
    if (auto ok = co_await answer(0.01); !ok) co_return ok;
    if (world_.load_jammed)
      co_return fail(ErrorCode::failed_precondition, "LOAD_JAMMED",
                     "load: the actuator is jammed: look at its pan and pulleys");
    ++world_.loads;
    world_.force_n = force_n;
    world_.load_rests_at_ns = time_.now().utc.utc_ns + nanoseconds_from_s(20).count();
    co_return Result<void>{};
  }
};

DeviceDescription device(const char* id, const char* kind, double period_s) {
  DeviceDescription d;
  d.id = id;
  d.kind = kind;
  d.address = "127.0.0.1:1";
  d.period_s = period_s;
  return d;
}

}  // namespace

double SmallWorld::gauss() {
  const auto uniform = [this] {  // xorshift64*
    random_state ^= random_state >> 12;
    random_state ^= random_state << 25;
    random_state ^= random_state >> 27;
    return (static_cast<double>((random_state * 0x2545f4914f6cdd1d) >> 11) + 0.5) * 0x1.0p-53;
  };
  return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * std::numbers::pi * uniform());
}

CellDescription small_cell(const std::string& database) {
  CellDescription cell;
  cell.name = "small";
  cell.database = database;
  cell.text = "[cell]\nname = \"small\"\n";
  cell.hash = "5ca1ab1e";
  auto axis = device("axis", "pi-gcs", 0);
  axis.become<MotionSettings>().axes.push_back({{"q1", "mm"}, "X", -5, 5, 20});
  auto scanner = device("scanner", "keithley-2701", 5);
  for (int n = 1; n <= kThermometers; ++n) {
    ProbeDescription probe;
    probe.channel = {"t0" + std::to_string(n), "degC"};
    probe.input = 100 + n;
    probe.part = "robot";
    probe.u_k = 0.005;
    scanner.become<TemperatureSettings>().probes.push_back(probe);
  }
  auto laser = device("laser-x", "interferometer-adapter", 2);
  laser.become<LengthSettings>().channel = {"x", "mm"};
  cell.devices = {axis, scanner, laser, device("support", "watlow-ez-zone", 5)};
  cell.run.settle_s = 1;
  cell.run.quiet_nm = 80;
  cell.checks.drift_window_s = 20;
  cell.checks.stabiliser_wait_s = 600;
  return cell;
}

CellDescription small_cell_with_load(const std::string& database, bool actuator) {
  auto cell = small_cell(database);
  cell.load = LoadDescription{4.0, 0.002, 9.81};
  if (!actuator) return cell;
  auto load = device("load", "load-actuator", 10);
  load.become<LoadSettings>().force = {"force", "N"};
  cell.devices.push_back(load);
  return cell;
}

application::Devices small_devices(SmallWorld& world, VirtualTime& time,
                                   const CellDescription& cell) {
  application::Devices devices;
  devices.push_back(std::make_unique<Axis>(world, time, cell.devices[0], world.axis_away));
  devices.push_back(std::make_unique<Scanner>(world, time, cell.devices[1], world.scanner_away));
  devices.push_back(std::make_unique<Laser>(world, time, cell.devices[2], world.laser_away));
  devices.push_back(std::make_unique<Support>(world, time, cell.devices[3], world.support_away));
  for (const auto& description : cell.devices)
    if (description.role() == DeviceRole::load)
      devices.push_back(std::make_unique<Load>(world, time, description, world.load_away));
  return devices;
}

}  // namespace driftwise::tests
