#include "tests/statistics/micro_nano_case.h"

#include <array>
#include <cstdio>
#include <random>
#include <stdexcept>

#include "drivers/all_devices.h"
#include "server/correction/correction.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise::statistics {
namespace {

using testing_support::MicroNanoRow;

constexpr CellTime kRobotEpoch{1'600'000'000'000'000'000};
constexpr double kRoomStart_degc = 19;  // the plant's set point before the campaign
constexpr double kLargestFittedForce_n = 2.305;
constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};

correction::Stage stage_of(const CellDescription& cell) {
  correction::Stage stage;
  if (!cell.correction) return stage;
  stage.cosine = cell.correction->cosine;
  for (const auto& beam : cell.correction->beams) {
    const auto axis = static_cast<std::size_t>(beam.length.symbol[0] - 'x');
    stage.beams[axis] = {beam.offset_mm, beam.offset_per_mm};
  }
  return stage;
}

std::string thermometer(std::size_t i) {
  char name[8];
  std::snprintf(name, sizeof name, "t%02zu", i + 1);
  return name;
}

JudgedTarget judged(const MicroNanoRow& row) {
  using compensation::Variable;
  JudgedTarget target;
  target.at = kRobotEpoch + nanoseconds_from_s(row.time_s);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    target.true_pose.set(static_cast<Variable>(axis), row.true_mm[axis]);
    target.q_mm.push_back(row.q_mm[axis]);
  }
  target.true_pose.set(Variable::force, row.force_n);
  for (std::size_t i = 0; i < row.t_degc.size(); ++i)
    target.conditions.push_back({thermometer(i) + "_degC", row.t_degc[i]});
  return target;
}

}  // namespace

Dataset micro_nano_dataset(const std::vector<MicroNanoRow>& rows, const CellDescription& cell) {
  const auto stage = stage_of(cell);
  Dataset data;
  data.rows = rows.size();
  for (const char* q : {"q1", "q2", "q3"}) data.columns.push_back({{q, "mm"}, {}});
  for (const char* axis : kAxes) data.columns.push_back({{axis, "mm"}, {}});
  for (const char* axis : kAxes) data.columns.push_back({{std::string("r") + axis, "arcsec"}, {}});
  data.columns.push_back({{"force", "N"}, {}});
  for (std::size_t i = 0; i < 10; ++i) data.columns.push_back({{thermometer(i), "degC"}, {}});
  for (const auto& row : rows) {
    const auto pose = correction::pose_from_paths(
        row.path_mm, {row.r_arcsec[0], row.r_arcsec[1], row.r_arcsec[2]}, stage);
    for (std::size_t k = 0; k < 3; ++k) {
      data.columns[k].values.push_back(row.q_mm[k]);
      data.columns[3 + k].values.push_back(pose[k]);
      data.columns[6 + k].values.push_back(row.r_arcsec[k]);
    }
    data.columns[9].values.push_back(row.force_n);
    for (std::size_t i = 0; i < 10; ++i) data.columns[10 + i].values.push_back(row.t_degc[i]);
    data.time_s.push_back(row.time_s);
    data.set.push_back(row.calibration ? PointSet::calibration : PointSet::validation);
    data.line.push_back(row.line);
    data.zero.push_back(row.zero ? 1 : 0);
  }
  return data;
}

CellDescription micro_nano_cell() {
  auto cell = formats::read_cell_file(
      std::string(DRIFTWISE_SOURCE_DIR) + "/deploy/cells/micro-nano/cell.toml",
      drivers::all_devices());
  if (!cell) throw std::runtime_error(cell.error().message);
  return std::move(*cell);
}

SimulatedCase micro_nano_case_with(std::uint64_t seed, const std::vector<std::string>& overrides) {
  testing_support::MicroNanoOptions options;
  options.seed = seed;
  options.coarse = true;
  std::mt19937_64 random(seed);
  // Rooms that warm or cool: the published one drew to 4 K above where it began.
  const double towards_k = std::uniform_real_distribution<double>(-5, 5)(random);
  options.overrides = {"room.balance_degc=" + std::to_string(kRoomStart_degc + towards_k)};
  options.overrides.insert(options.overrides.end(), overrides.begin(), overrides.end());
  testing_support::MicroNanoSession session(DRIFTWISE_SOURCE_DIR, options);
  SimulatedCase out;
  out.zero_at = kRobotEpoch + nanoseconds_from_s(session.now_s());
  out.cell = micro_nano_cell();
  out.formula = "q ~ poly(x, y, z, 3) + F + F^2 + F^3 + t04..t10 + (F + t04):poly(x, y, z, 2)";
  std::uniform_real_distribution<double> inside(0.0, 2.5);
  std::vector<MicroNanoRow> rows;
  double force_n = 0;
  for (const auto& grid : options.grids) {
    if (grid.force_n > kLargestFittedForce_n) break;
    if (grid.force_n != force_n) session.load(force_n = grid.force_n);
    const int count = grid.calibration ? 6 : 5;
    const double first_mm = grid.calibration ? 0 : 0.25;
    for (int line = 0; line < count * count; ++line) {
      for (int k = 0; k <= count; ++k) {  // the last one: back to zero
        const bool zero = k == count;
        auto row =
            session.visit(zero ? std::array{0.0, 0.0, 0.0}
                               : std::array{first_mm + 0.5 * (line / count),
                                            first_mm + 0.5 * (line % count), first_mm + 0.5 * k});
        row.calibration = grid.calibration;
        row.zero = zero;
        row.line = line;
        rows.push_back(row);
      }
      out.targets.push_back(
          judged(session.visit({inside(random), inside(random), inside(random)})));
    }
  }
  out.dataset = micro_nano_dataset(rows, out.cell);
  return out;
}

SimulatedCase micro_nano_case(std::uint64_t seed) { return micro_nano_case_with(seed, {}); }

}  // namespace driftwise::statistics
