#include "tests/statistics/linear_axis_case.h"

#include <cstdio>
#include <random>
#include <stdexcept>

#include "drivers/all_devices.h"
#include "drivers/simulated/plant/file/make_plant.h"
#include "server/formats/cell_file/cell_file.h"
#include "tests/support/plant_campaign.h"

namespace driftwise::statistics {
namespace {

constexpr simulated::TimeNs kAxisEpoch = 1'600'000'000'000'000'000;

std::string setting(const char* name, double value) {
  return std::string(name) + "=" + std::to_string(value);
}

// Two faces with conductance h in series with that of the metal behind them, W/m2K.
double in_series(double h, double metal) { return 1 / (1 / h + 1 / metal); }

// Another machine in another room: each figure anywhere in the range that plant.toml states for it,
// and a set-point that is moved by up to the published 2 K in either direction.
std::vector<std::string> machine_and_room(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto within = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  const auto screwed = [&] { return within(1000, 5000); };  // W/m2K
  std::vector<std::string> settings;
  settings.push_back("room.schedule=[[0.0833, " + std::to_string(within(18, 22)) +
                     "], [4.5, 20.0]]");
  settings.push_back(setting("link.support_bridge.conductance_w_m2k", in_series(screwed(), 5567)));
  settings.push_back(setting("link.support_carrier.conductance_w_m2k", in_series(screwed(), 4175)));
  settings.push_back(setting("link.base_lower_arm.conductance_w_m2k", screwed()));
  settings.push_back(setting("link.arm_stage.conductance_w_m2k", screwed()));
  settings.push_back(setting("link.cover_inside.conductance_w_m2k", within(2, 4)));
  settings.push_back(setting("link.cover_leak.flow_m3_h", within(0, 10)));
  settings.push_back(setting("material.aluminium.expansion_ppm_k", within(21.5, 23.6)));
  return settings;
}

}  // namespace

std::string axis_sensor(std::size_t i) {
  char name[8];
  std::snprintf(name, sizeof name, "t%02zu", i + 1);
  return name;
}

SimulatedCase linear_axis_case(std::uint64_t seed) {
  return linear_axis_machine(seed, {}).measured;
}

LinearAxisMachine linear_axis_machine(std::uint64_t seed, const std::string& schedule) {
  auto settings = machine_and_room(seed);
  if (!schedule.empty()) settings.front() = "room.schedule=" + schedule;
  LinearAxisMachine made;
  made.plant = simulated::make_plant(testing_support::linear_axis_plant_file(DRIFTWISE_SOURCE_DIR),
                                     {.seed = seed, .overrides = settings, .epoch_ns = kAxisEpoch});
  const auto campaign = testing_support::run_plant_campaign(*made.plant, kAxisEpoch);
  SimulatedCase& out = made.measured;
  const std::string file =
      std::string(DRIFTWISE_SOURCE_DIR) + "/deploy/cells/linear-axis/cell.toml";
  auto cell = formats::read_cell_file(file, drivers::all_devices());
  if (!cell) throw std::runtime_error(cell.error().message);
  out.cell = std::move(*cell);
  out.formula = "q1 ~ x + x^2 + t05..t10";  // the sensors on the robot: what may be served to it
  out.zero_at = CellTime{kAxisEpoch} + nanoseconds_from_s(campaign.zero_s);
  auto& data = out.dataset;
  data.rows = campaign.rows.size();
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  for (std::size_t i = 0; i < 10; ++i) data.columns.push_back({{axis_sensor(i), "degC"}, {}});
  for (const auto& row : campaign.rows) {
    data.time_s.push_back(row.time_s);
    data.set.push_back(row.calibration ? PointSet::calibration : PointSet::validation);
    data.columns[0].values.push_back(row.q1_mm);
    data.columns[1].values.push_back(row.x_mm);
    for (std::size_t i = 0; i < 10; ++i) data.columns[2 + i].values.push_back(row.t_degc[i]);
    if (row.calibration) continue;
    auto& target = out.targets.emplace_back();
    target.at = CellTime{kAxisEpoch} + nanoseconds_from_s(row.time_s);
    target.true_pose.set(compensation::Variable::x,
                         (row.end_effector_nm - campaign.zero_end_effector_nm) * 1e-6);
    for (std::size_t i = 0; i < 10; ++i)
      target.conditions.push_back({axis_sensor(i) + "_degC", row.t_degc[i]});
    target.q_mm = {row.q1_mm};
  }
  return made;
}

}  // namespace driftwise::statistics
