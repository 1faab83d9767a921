#include "tests/hidden_effects/accepting/foreign_truth.h"

#include <algorithm>

namespace driftwise::hidden {
namespace {

constexpr std::size_t kWithheldParts = 25, kWithheldEvery = 5;
constexpr const char* kTilts[] = {"rx", "ry", "rz"};

void add_asked(TrueRows& truth, const std::string& symbol, const Eigen::VectorXd& values) {
  truth.asked.push_back({*compensation::variable_from(symbol), {values.begin(), values.end()}});
}

}  // namespace

bool holds_rows_out(const Dataset& data) {
  return std::ranges::find(data.set, PointSet::validation) != data.set.end();
}

void withhold_rows(Dataset& data) {
  data.excluded.assign(data.rows, 0);
  for (std::size_t row = 0; row < data.rows; ++row)
    if (row * kWithheldParts / data.rows % kWithheldEvery == kWithheldEvery - 1)
      data.excluded[row] = 1;
}

TrueRows foreign_truth(const foreign::Generated& made, const Dataset& data, CellTime time_zero,
                       UnlistedEffectOf unlisted) {
  const auto& campaign = made.campaign;
  const bool is_of_robot = made.order.kind == "unlisted" && unlisted == UnlistedEffectOf::robot;
  TrueRows truth;
  truth.time_zero = time_zero;
  truth.time_s.assign(campaign.time_s.begin(), campaign.time_s.end());
  for (int j = 0; j < campaign.robot.axes; ++j) {
    Eigen::VectorXd pose = made.true_pose.col(j).array() + made.error_at_zero[j];
    if (is_of_robot) pose += made.instrument_error.col(j);
    add_asked(truth, campaign.robot.pose[static_cast<std::size_t>(j)], pose);
    auto& motor = truth.motor_mm.emplace_back();
    for (int row = 0; row < campaign.rows(); ++row)
      motor.push_back(campaign.robot.motor_value(j, campaign.s(row, j)));
  }
  for (int k = 0; campaign.has_tilts && k < 3; ++k)
    add_asked(truth, kTilts[k], campaign.tilt.col(k));
  if (campaign.has_force) add_asked(truth, "force", campaign.force_n);
  const bool held_out = holds_rows_out(data);
  for (std::size_t row = 0; row < data.rows; ++row)
    truth.judged.push_back(held_out ? data.set_of(row) == PointSet::validation
                                    : data.is_excluded(row));
  return truth;
}

}  // namespace driftwise::hidden
