#include "server/application/motion/sampling.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "server/application/motion/point_decision.h"
#include "server/application/recording/doubts.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

Reading readback(const DeviceDescription& controller, const MotionState& state,
                 std::int64_t sequence) {
  Reading reading{controller.id, state.at, state.at, sequence, {}};
  const auto& axes = controller.axes();
  for (std::size_t i = 0; i < std::min(axes.size(), state.q_mm.size()); ++i)
    reading.values.push_back({axes[i].channel.name(), state.q_mm[i]});
  return reading;
}

// Readings of all controllers, shown as they come; the result: where all axes of the cell are.
Awaitable<Result<std::vector<double>>> read_axes(Workbench& bench, std::int64_t sequence,
                                                 std::vector<Reading>& readings) {
  auto& devices = bench.devices;
  DRIFTWISE_CO_TRY(const auto states, co_await devices.motion_states());
  std::vector<double> q_mm;
  const auto& controllers = devices.with_role(DeviceRole::motion);
  for (std::size_t i = 0; i < states.size(); ++i) {
    readings.push_back(readback(devices.description(controllers[i]), states[i], sequence));
    bench.recorder.observe(JudgedReading{readings.back(), {}});
    q_mm.insert(q_mm.end(), states[i].q_mm.begin(), states[i].q_mm.end());
  }
  co_return q_mm;
}

bool is_of_pose(const std::string& name) {
  const auto channel = parse_robot_channel(name);
  return channel && is_pose_symbol(without_robot(channel->symbol));
}

// About the first value: means of mm must keep their nanometres.
double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v - values.front();
  return values.front() + sum / static_cast<double>(values.size());
}

// Of the readbacks, against where the axes were sent and among themselves.
void gate_readback(const CellDescription& description, const std::vector<double>& commanded_mm,
                   Sampling& sampling) {
  const auto motors = description.motor_channels();
  for (std::size_t axis = 0; axis < motors.size(); ++axis) {
    std::optional<double> low, high;
    for (const auto& reading : sampling.readings) {
      const double* q_mm = reading.find(motors[axis].name());
      if (q_mm == nullptr) continue;
      low = std::min(low.value_or(*q_mm), *q_mm);
      high = std::max(high.value_or(*q_mm), *q_mm);
      if (axis < commanded_mm.size())
        sampling.off_nm =
            std::max(sampling.off_nm, std::abs(nm_from_mm(*q_mm - commanded_mm[axis])));
    }
    if (low)
      sampling.peak_to_peak_nm = std::max(sampling.peak_to_peak_nm, nm_from_mm(*high - *low));
  }
}

// Coordinates that the set-up lets be out of their range, and that are: no value, a rejected one,
// or one outside. They leave no rejection behind.
void note_out_of_range(const SetupDescription* setup, std::vector<JudgedReading>& round,
                       std::set<std::string>& out_of_range) {
  if (!setup) return;
  for (const auto& coordinate : setup->coordinates) {
    if (!coordinate.may_be_missing()) continue;
    const std::string name = coordinate.channel.name();
    const auto reading = std::ranges::find(round, coordinate.device, &JudgedReading::device);
    const double* read = reading == round.end() ? nullptr : reading->find(name);
    const double value = read ? coordinate.scale * *read + coordinate.offset : kMissing;
    const bool is_inside = !(coordinate.min && value < *coordinate.min) &&
                           !(coordinate.max && value > *coordinate.max);
    if (!is_missing(value) && is_inside && !reading->is_rejected(name)) continue;
    out_of_range.insert(name);
    if (reading != round.end())
      std::erase_if(reading->rejected,
                    [&name](const RejectedValue& one) { return one.channel == name; });
  }
}

// The largest of the instruments that gave it here.
double declared_arcsec(const CellDescription& description, const Channel& angle,
                       const std::vector<Reading>& readings) {
  double u_arcsec = 0;
  for (const auto& reading : readings)
    if (const auto* device = description.find_device(reading.device))
      for (const auto& one : device->angles())
        if (one.channel == angle) u_arcsec = std::max(u_arcsec, one.u_arcsec);
  return u_arcsec;
}

void summarise(const CellDescription& description, const std::set<std::string>& out_of_range,
               Sampling& sampling) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> values;
  for (const auto& reading : sampling.readings)
    for (const auto& value : reading.values) {
      if (is_missing(value.value) || out_of_range.contains(value.channel)) continue;
      auto& list = values[value.channel];
      if (list.empty()) order.push_back(value.channel);
      list.push_back(value.value);
    }
  for (const auto& channel : description.motor_channels())
    sampling.q_mm.push_back(mean(values[channel.name()]));
  for (const auto& length : description.length_channels()) {
    const auto& list = values[length.name()];
    if (list.empty()) continue;
    const double spread = spread_nm(list);
    sampling.spreads_nm.push_back({length.symbol + "_std_nm", spread});
    if (is_missing(sampling.spread_nm) || spread > sampling.spread_nm) sampling.spread_nm = spread;
  }
  for (const auto& angle : description.angle_channels())
    if (const auto& list = values[angle.name()]; !list.empty())
      sampling.rotations.push_back({angle.name(), standard_deviation(list),
                                    declared_arcsec(description, angle, sampling.readings)});
  for (const auto& name : order) {
    const bool is_motor = is_motor_symbol(without_robot(name.substr(0, name.rfind('_'))));
    const bool is_spread =
        name.ends_with("_std_nm");  // of the device's own samples: stays in its reading
    if (!is_motor && !is_spread) sampling.raw.push_back({name, mean(values[name])});
  }
}

// The zero: an interferometer that lost its beam out of its range has it again there, or is zeroed.
bool is_zero(const std::vector<double>& commanded_mm) {
  constexpr double kNear_mm = 0.01;  // a compensated zero is some micrometres off
  return !commanded_mm.empty() &&
         std::ranges::all_of(commanded_mm, [](double q_mm) { return std::abs(q_mm) <= kNear_mm; });
}

// What was read before something in it was rejected: no attempt has it.
void keep(RunScope& scope, Sampling& sampling) {
  for (auto& reading : sampling.readings) scope.bench.writer.add(std::move(reading));
  sampling.readings.clear();
}

// One round of all instruments as a reading of the pose, for those who watch; nothing is stored of
// it.
void show_pose(RunScope& scope, const std::vector<JudgedReading>& round, std::int64_t number) {
  if (scope.bench.pose.is_identity() || round.empty()) return;
  std::vector<ChannelValue> raw;
  Reading shown{"pose", round.front().start, round.front().end, number, {}};
  for (const auto& reading : round) {
    shown.start = std::min(shown.start, reading.start);
    shown.end = std::max(shown.end, reading.end);
    for (const auto& value : reading.values)
      if (is_of_pose(value.channel)) raw.push_back(value);
  }
  for (auto& value : scope.bench.pose.pose(raw))
    if (is_of_pose(value.channel)) shown.values.push_back(std::move(value));
  scope.bench.recorder.show(shown);
}

}  // namespace

Awaitable<Result<void>> look_at_pose(RunScope& scope) {
  auto& bench = scope.bench;
  std::vector<Reading> readbacks;
  DRIFTWISE_CO_TRY(const auto q_mm, co_await read_axes(bench, 0, readbacks));
  DRIFTWISE_CO_TRY(auto round, co_await bench.devices.read_pose_instruments());
  std::set<std::string> out_of_range;
  note_out_of_range(bench.devices.setup(), round, out_of_range);
  std::vector<ChannelValue> raw;
  for (const auto& reading : round) {
    bench.recorder.observe(reading);
    for (const auto& value : reading.values)
      if (!is_missing(value.value) && !out_of_range.contains(value.channel)) raw.push_back(value);
  }
  if (auto good = bench.doubts.check_round(round, q_mm); !good) {
    for (auto& reading : round) bench.writer.add(std::move(reading));
    co_return good;
  }
  co_return bench.doubts.check_pose(bench.pose.pose(raw), q_mm);
}

Awaitable<Result<Sampling>> take_readings(RunScope& scope, int count,
                                          std::vector<double> commanded_mm) {
  scope.phase("reading");
  auto& devices = scope.bench.devices;
  Sampling sampling;
  std::set<std::string> out_of_range;
  std::optional<CellTime> first, last;
  for (int k = 0; k <= count; ++k) {
    DRIFTWISE_CO_TRY(const auto q_mm, co_await read_axes(scope.bench, k, sampling.readings));
    // The last look at the axes decides too: they may have moved during the last reading.
    DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
    if (k == count) break;
    DRIFTWISE_CO_TRY(auto round, co_await devices.read_pose_instruments(is_zero(commanded_mm)));
    note_out_of_range(devices.setup(), round, out_of_range);
    for (const auto& reading : round) {
      if (!first || reading.middle() < *first) first = reading.middle();
      if (!last || reading.middle() > *last) last = reading.middle();
      scope.bench.recorder.observe(reading);
    }
    const auto good = scope.bench.doubts.check_round(round, q_mm);
    if (good) show_pose(scope, round, k);
    for (auto& reading : round) sampling.readings.push_back(std::move(reading));
    if (!good) {
      keep(scope, sampling);
      co_return tl::unexpected(good.error());
    }
    DRIFTWISE_CO_RETURN_IF_ERROR(scope.control.check());
  }
  summarise(scope.bench.description, out_of_range, sampling);
  gate_readback(scope.bench.description, commanded_mm, sampling);
  sampling.means = scope.bench.pose.pose(sampling.raw);
  if (auto good = scope.bench.doubts.check_pose(sampling.means, sampling.q_mm); !good) {
    keep(scope, sampling);
    co_return tl::unexpected(good.error());
  }
  const auto now = scope.bench.clock.now();
  const auto middle =
      first ? CellTime{first->utc_ns + (last->utc_ns - first->utc_ns) / 2} : now.utc;
  sampling.measured = {middle, now.monotonic_ns - (now.utc - middle).count()};
  co_return sampling;
}

}  // namespace driftwise::application
