#include "tests/support/plant_cell.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "drivers/all_devices.h"
#include "server/core/ports/control/tunable_loop.h"
#include "server/formats/cell_file/cell_file.h"
#include "tests/support/plant_campaign.h"

namespace driftwise::tests {
namespace {

constexpr double kMmPerNm = 1e-6;

// Every exchange takes time.
template <class Port>
class InPlant : public Port {
 public:
  InPlant(PlantWorld& world, VirtualTime& time, DeviceDescription description, int index)
      : world_(world), time_(time), description_(std::move(description)), index_(index) {}
  const DeviceDescription& description() const override { return description_; }
  DeviceHealth health() const override {
    DeviceHealth health;
    health.link = LinkState::connected;
    return health;
  }
  Awaitable<Result<void>> prepare() override {
    co_await pass(0.02);
    co_return Result<void>{};
  }
  void close() override {}

 protected:
  Awaitable<void> pass(double seconds) {
    co_await time_.sleep_until(time_.now().utc + nanoseconds_from_s(seconds));
  }
  simulated::TimeNs now() const { return time_.now().utc.utc_ns; }
  void say(Reading& reading, const std::string& channel, double value) const {
    reading.values.push_back({channel, world_.liar.say(channel, value, time_.now().utc)});
  }
  std::string option(const char* name, const char* otherwise) const {
    const auto found = description_.options.find(name);
    return found == description_.options.end() ? otherwise : found->second;
  }

  PlantWorld& world_;
  VirtualTime& time_;
  DeviceDescription description_;
  int index_;
  std::int64_t sequence_ = 0;
};

class Controller final : public InPlant<MotionController> {
 public:
  using InPlant::InPlant;
  Awaitable<Result<MotionState>> state() override {
    co_await pass(0.005);
    MotionState state{time_.now().utc, {}, false, true, true};
    for (int i = 0; i < axes(); ++i) {
      const auto axis = world_.plant->axis(i, now());
      state.q_mm.push_back(world_.liar.say(channel(i), axis.q_mm, time_.now().utc));
      state.moving = state.moving || axis.moving || axis.referencing;
      state.referenced = state.referenced && axis.referenced;
      state.on_target = state.on_target && axis.on_target;
    }
    co_return state;
  }
  Awaitable<Result<void>> home() override {
    for (int i = 0; i < axes(); ++i) world_.plant->start_reference(i, now());
    bool busy = true;
    while (busy) {
      co_await pass(0.5);
      busy = false;
      for (int i = 0; i < axes(); ++i) busy = busy || world_.plant->axis(i, now()).referencing;
    }
    co_return Result<void>{};
  }
  Awaitable<Result<void>> start_move(std::span<const double> q_mm) override {
    const std::vector<double> targets(q_mm.begin(), q_mm.end());
    co_await pass(0.01);
    for (int i = 0; i < axes(); ++i)
      world_.plant->start_move(i, targets[static_cast<std::size_t>(i)], now());
    co_return Result<void>{};
  }
  Awaitable<Result<void>> stop() override {
    for (int axis = 0; axis < world_.plant->axis_count(); ++axis)
      world_.plant->halt_axis(axis, now());
    co_await pass(0.005);
    co_return Result<void>{};
  }

 private:
  int axes() const { return static_cast<int>(description_.axes().size()); }
  std::string channel(int i) const {
    return description_.axes()[static_cast<std::size_t>(i)].channel.name();
  }
};

class Interferometer final : public InPlant<Instrument> {
 public:
  using InPlant::InPlant;
  Awaitable<Result<Reading>> read() override {
    const int samples = std::stoi(option("samples", "2048"));
    const auto start = time_.now().utc;
    co_await pass(samples / world_.plant->sample_rate_hz() + 0.01);
    const auto read = world_.plant->measure_length(index_, start.utc_ns, samples);
    if (read.beam_broken)
      co_return fail(ErrorCode::failed_precondition, "BEAM_LOST", description_.id + ": beam lost");
    Reading reading{description_.id, start, time_.now().utc, ++sequence_, {}};
    say(reading, description_.length()->channel.name(), read.mean_nm * kMmPerNm);
    reading.values.push_back({description_.length()->channel.symbol + "_std_nm", read.std_nm});
    say(reading, option("air_channel", "air_degC"), read.air_degc);
    say(reading, option("level_channel", "level_pct"), read.level_pct);
    co_return reading;
  }
  Awaitable<Result<void>> zero() override {
    co_await pass(0.1);
    world_.plant->zero_length(index_, now());
    world_.liar.zeroed(description_.length()->channel.name());
    co_return Result<void>{};
  }
};

class Collimator final : public InPlant<Instrument> {
 public:
  using InPlant::InPlant;
  Awaitable<Result<Reading>> read() override {
    constexpr double kAverage_s = 0.5;
    const auto start = time_.now().utc;
    co_await pass(kAverage_s);
    const auto read = world_.plant->measure_angle(index_, kAverage_s, now());
    Reading reading{description_.id, start, time_.now().utc, ++sequence_, {}};
    for (const auto& angle : description_.angles())
      say(reading, angle.channel.name(),
          angle.sign * (angle.device_axis == 1 ? read.y_arcsec : read.z_arcsec));
    co_return reading;
  }
  Awaitable<Result<void>> zero() override {
    co_return fail(ErrorCode::failed_precondition, "NO_ZERO", "an autocollimator has no zero");
  }
};

class Thermometers final : public InPlant<Instrument> {
 public:
  using InPlant::InPlant;
  Awaitable<Result<Reading>> read() override {
    const auto start = time_.now().utc;
    co_await pass(4.3);
    Reading reading{description_.id, start, time_.now().utc, ++sequence_, {}};
    for (const auto& probe : description_.probes()) {
      const double ohm = world_.plant->probe_ohm(probe.input, now());
      say(reading, probe.channel.name(),
          std::isnan(ohm) ? kMissing
                          : testing_support::degc_from_ohm(ohm, probe.r0_ohm, probe.a_per_degc,
                                                           probe.b_per_degc2));
    }
    co_return reading;
  }
  Awaitable<Result<void>> zero() override {
    co_return fail(ErrorCode::failed_precondition, "NO_ZERO", "a scanner has no zero");
  }
};

class SupportLoop final : public InPlant<Stabiliser>, public TunableLoop {
 public:
  using InPlant::InPlant;
  Awaitable<Result<Reading>> read() override {
    const auto start = time_.now().utc;
    co_await pass(0.05);
    const auto state = world_.plant->stabiliser(index_, now());
    Reading reading{description_.id, start, time_.now().utc, ++sequence_, {}};
    std::string stem = description_.id;
    std::ranges::replace(stem, '-', '_');
    say(reading, stem + "_degC", state.process_degc);
    say(reading, stem + "_set_degC", state.set_point_degc);
    say(reading, stem + "_power_pct", state.heat_pct - state.cool_pct);
    co_return reading;
  }
  Awaitable<Result<void>> set_point(double degc) override {
    co_await pass(0.05);
    world_.plant->set_set_point_degc(index_, degc, now());
    co_return Result<void>{};
  }
  LoopTuning declared_tuning() const override { return {}; }
  Awaitable<Result<LoopTuning>> tuning() override {
    co_await pass(0.05);
    co_return tuning_;
  }
  Awaitable<Result<LoopTuning>> set_tuning(LoopTuning wanted) override {
    co_await pass(0.05);
    tuning_ = changed(tuning_, wanted);
    world_.plant->set_stabiliser_tuning(index_, *tuning_.heat_band_k, *tuning_.cool_band_k,
                                        *tuning_.integral_s, *tuning_.derivative_s, now());
    co_return tuning_;
  }

 private:
  LoopTuning tuning_{2, 2, 180, 0};
};

class Weights final : public InPlant<LoadActuator> {
 public:
  using InPlant::InPlant;
  Awaitable<Result<LoadState>> state() override {
    co_await pass(0.01);
    const auto load = world_.plant->load(now());
    co_return LoadState{time_.now().utc,
                        world_.liar.say(description_.force()->name(), load.newton, time_.now().utc),
                        load.resting};
  }
  Awaitable<Result<void>> set_force(double force_n) override {
    co_await pass(0.01);
    world_.plant->set_load(force_n, now());
    co_return Result<void>{};
  }
};

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string folder_of(const std::string& cell) {
  return std::string(DRIFTWISE_SOURCE_DIR) + "/deploy/cells/" + cell + "/";
}

}  // namespace

double Liar::say(const std::string& channel, double value, CellTime at) {
  auto& known = true_[channel];
  known.push_back({at, value});
  if (known.size() > 2000) known.pop_front();
  if (!lie_ || channel != channel_) return value;
  if (!first_) first_ = at;
  last_ = at;
  const double said = lie_(value, at);
  if (zeroed_ && std::isfinite(said)) taken_off_ = said - value;
  zeroed_ = false;
  return said - taken_off_;
}

double Liar::truth(const std::string& channel) const {
  const auto found = true_.find(channel);
  return found == true_.end() || found->second.empty() ? kMissing : found->second.back().value;
}

double Liar::truth(const std::string& channel, CellTime at) const {
  const auto found = true_.find(channel);
  if (found == true_.end() || found->second.empty()) return kMissing;
  const auto& known = found->second;
  const auto after =
      std::ranges::upper_bound(known, at, {}, [](const Said& said) { return said.at; });
  return after == known.begin() ? after->value : std::prev(after)->value;
}

PlantWorld make_plant_world(const std::string& cell, CellTime begin, std::uint64_t seed,
                            bool coarse) {
  PlantWorld world;
  simulated::PlantOptions options{.seed = seed, .overrides = {}, .epoch_ns = begin.utc_ns};
  if (coarse && cell == "micro-nano") options.overrides.push_back("plant.step_s=2.0");
  world.plant = simulated::make_any_plant(folder_of(cell) + "plant.toml", options);
  if (coarse) world.plant->set_instants_per_reading(1);
  return world;
}

CellDescription shipped_cell(const std::string& cell, const std::string& database) {
  auto read = formats::read_cell_file(folder_of(cell) + "cell.toml", drivers::all_devices());
  if (!read) throw std::runtime_error(read.error().message);
  read->database = database;
  return std::move(*read);
}

std::string shipped_trajectory(const std::string& cell) {
  return text_of(folder_of(cell) + "trajectories/published.csv");
}

application::Devices plant_devices(PlantWorld& world, VirtualTime& time,
                                   const CellDescription& cell) {
  application::Devices devices;
  int lasers = 0, collimators = 0, supports = 0;
  for (const auto& one : cell.devices) {
    switch (one.role()) {
      case DeviceRole::motion:
        devices.push_back(std::make_unique<Controller>(world, time, one, 0));
        break;
      case DeviceRole::length:
        devices.push_back(std::make_unique<Interferometer>(world, time, one, lasers++));
        break;
      case DeviceRole::angle:
        devices.push_back(std::make_unique<Collimator>(world, time, one, collimators++));
        break;
      case DeviceRole::temperature:
        devices.push_back(std::make_unique<Thermometers>(world, time, one, 0));
        break;
      case DeviceRole::stabiliser:
        devices.push_back(std::make_unique<SupportLoop>(world, time, one, supports++));
        break;
      case DeviceRole::load:
        devices.push_back(std::make_unique<Weights>(world, time, one, 0));
        break;
      default:
        throw std::runtime_error("device " + one.id + " has no twin in memory");
    }
  }
  return devices;
}

}  // namespace driftwise::tests
