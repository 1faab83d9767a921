// Effects hidden in data are a robot's matter, not a lie: no row of 100 data sets is rejected or
// marked, but by what is larger than a limit.

#include <gtest/gtest.h>

#include <cmath>

#include "server/plausibility/closure_judge.h"
#include "server/plausibility/geometry_judge.h"
#include "server/plausibility/value_judge.h"
#include "tests/hidden_effects/shapes/hidden_world.h"

namespace driftwise::lies {
namespace {

using hidden::Robot;

constexpr double kSamePlace_mm = 0.01;

CellDescription cell_of(const Dataset& data, Robot robot) {
  CellDescription cell;
  DeviceDescription axes, scanner;
  axes.id = "axis";
  scanner.id = "scanner";
  for (const auto& column : data.columns) {
    const auto& channel = column.channel;
    if (is_motor_symbol(channel.symbol))
      axes.become<MotionSettings>().axes.push_back({channel, channel.symbol, -5, 5, 0});
    if (is_structure_temperature(channel)) {
      ProbeDescription probe;
      probe.channel = channel;
      probe.part = "robot";
      scanner.become<TemperatureSettings>().probes.push_back(probe);
    }
    if (is_pose_symbol(channel.symbol) && channel.unit == "mm") {
      DeviceDescription laser;
      laser.id = "laser-" + channel.symbol;
      laser.become<LengthSettings>().channel = channel;
      cell.devices.push_back(laser);
    }
  }
  cell.devices.push_back(axes);
  cell.devices.push_back(scanner);
  if (robot == Robot::linear_axis) {
    auto& kinematics = cell.kinematics.emplace();
    kinematics.kind = "linear-axis";
    kinematics.axes.push_back({{"q1", "mm"}, {"x", "mm"}, 0, 0});
  }
  return cell;
}

std::vector<ChannelValue> values_of(const Dataset& data, std::size_t row, bool motors) {
  std::vector<ChannelValue> values;
  for (const auto& column : data.columns)
    if (motors ? is_motor_symbol(column.channel.symbol) : is_pose_symbol(column.channel.symbol))
      values.push_back({column.channel.name(), column.values[row]});
  return values;
}

// Everything that is found false in the data set, as sentences.
std::vector<std::string> found_in(const Dataset& data, Robot robot) {
  const auto cell = cell_of(data, robot);
  plausibility::ValueJudge values(cell);
  const plausibility::GeometryJudge geometry(cell);
  plausibility::ClosureJudge closures(cell);
  std::vector<std::string> found;
  std::optional<std::size_t> zero;
  for (std::size_t row = 0; row < data.rows; ++row) {
    const CellTime at = CellTime{} + nanoseconds_from_s(data.time_s[row]);
    for (const auto& device : cell.devices) {
      JudgedReading reading;
      reading.device = device.id;
      reading.start = reading.end = at;
      const auto add = [&](const Channel& channel) {
        reading.values.push_back({channel.name(), data.find(channel.symbol)->values[row]});
      };
      for (const auto& probe : device.probes()) add(probe.channel);
      for (const auto& axis : device.axes()) add(axis.channel);
      if (device.length()) add(device.length()->channel);
      for (const auto& finding : values.judge(reading)) found.push_back(finding.reason);
    }
    // The worlds have no rows marked as zero: they come back to where they began.
    const auto here = values_of(data, row, false);
    const auto began = values_of(data, zero.value_or(row), false);
    bool is_zero = true;
    for (std::size_t i = 0; i < here.size(); ++i)
      is_zero = is_zero && std::abs(here[i].value - began[i].value) < kSamePlace_mm;
    if (!zero) {
      zero = row;
      closures.begin(at, {});
    }
    const auto q = values_of(data, row, true), q_zero = values_of(data, *zero, true);
    auto pose = values_of(data, row, false);
    const auto pose_zero = values_of(data, *zero, false);
    for (std::size_t i = 0; i < pose.size(); ++i) pose[i].value -= pose_zero[i].value;
    if (const auto compared = geometry.compare(pose, q, q_zero); compared.disagrees())
      found.push_back(compared.sentence());
    if (!is_zero || robot != Robot::linear_axis) continue;
    const double nm = 1e6 * (pose.front().value - (q.front().value - q_zero.front().value));
    if (const auto verdict = closures.judge({at, {nm}, {}, {}}); !verdict.good)
      found.push_back(verdict.sentence);
  }
  return found;
}

TEST(HiddenEffects, AreNoLies) {
  int sets = 0;
  for (const Robot robot : {Robot::linear_axis, Robot::micro_nano})
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      auto kinds = hidden::hideable(robot, seed);
      const auto& hidden = kinds[seed % kinds.size()];
      const auto made = hidden::make({.robot = robot}, {hidden}, seed);
      EXPECT_EQ(found_in(made.data, robot), std::vector<std::string>{})
          << hidden.cause << ", seed " << seed;
      ++sets;
    }
  EXPECT_EQ(sets, 100);
}

// What is larger than a limit is found: the same data with a jump of the length of 0.1 mm.
TEST(HiddenEffects, AJumpBeyondTheLimitIsFound) {
  auto made = hidden::make({}, {}, 1);
  for (auto& column : made.data.columns)
    if (column.channel.symbol == "x")
      for (std::size_t row = made.data.rows / 2; row < made.data.rows; ++row)
        column.values[row] += 0.1;
  EXPECT_FALSE(found_in(made.data, Robot::linear_axis).empty());
}

}  // namespace
}  // namespace driftwise::lies
