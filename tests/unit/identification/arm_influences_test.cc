// Declared errors of a tracker in the joints of an arm's targets. The oracle is another
// identification, with that error in the measured pose, served side by side with the first.

#include <gtest/gtest.h>

#include "server/compensation/forward_pose.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/identification/pose_influences.h"
#include "server/kinematics/drawing.h"
#include "tests/unit/identification/robots.h"

namespace driftwise::identification {
namespace {

using compensation::Snapshot;
using compensation::UncertaintySource;
using compensation::Variable;

constexpr CellTime kThen{1'300'000'000'000'000'000};

KinematicsDescription lifting_arm() {
  KinematicsDescription arm;
  arm.kind = "serial-arm";
  arm.links = {{.motor = {"q1", "rad"}, .d_mm = 300, .alpha_deg = 90},
               {.motor = {"q2", "rad"}, .a_mm = 500},
               {.motor = {"q3", "rad"}, .a_mm = 400}};
  return arm;
}

enum class Datums { one, two };  // the second 1 mm further on in x

Dataset rows_of_arm(Datums datums = Datums::one) {
  auto built = lifting_arm();
  built.links[0].d_mm += 0.3;
  built.links[1].a_mm -= 0.4;
  built.links[2].theta_deg += 0.05;
  built.frame = {.x_mm = 20, .y_mm = -10, .z_mm = 5, .rx_deg = 0.2, .ry_deg = -0.1, .rz_deg = 3};
  auto data = robots::arm_campaign(built, 150, 1e-3, 4);
  for (std::size_t row = 0; row < data.rows; ++row)
    data.time_s.push_back(40.0 * static_cast<double>(row));
  if (datums == Datums::one) return data;
  data.datum.assign(data.rows, 1);
  for (std::size_t row = 60; row < data.rows; ++row) {
    data.datum[row] = 2;
    data.columns[3].values[row] += 1;
  }
  return data;
}

Identification identified(const Dataset& data) {
  const auto found =
      identify(data, {.mechanism = *kinematics::make_mechanism(lifting_arm()), .terms = {}});
  EXPECT_TRUE(found) << found.error().message;
  return *found;
}

Snapshot served(const Dataset& data, const CellDescription& cell) {
  const auto found = identified(data);
  calibration::Model model;
  model.geometry = calibration::Geometry{
      kinematics::with_values(*found.mechanism, found.values()), {}, found.covariance};
  for (const auto& [parameter, value, error, free, note] : found.parameters)
    model.geometry->parameters.push_back({parameter.name, value, error, free, note});
  for (const auto& channel : found.mechanism->outputs()) {
    auto& output = model.outputs.emplace_back();
    output.channel = channel;
    output.coefficients.resize(0);
    output.accuracy.a90_calibration = 1.6e-3;
  }
  for (const auto& column : data.columns) {
    const auto [low, high] = std::ranges::minmax(column.values);
    model.domain.push_back({column.channel, low, high});
  }
  const auto added = add_pose_influences(data, found, model);
  EXPECT_TRUE(added) << added.error().message;
  const auto builder = compensation::SnapshotBuilder::create(model, ModelId{1}, cell);
  EXPECT_TRUE(builder) << builder.error().message;
  return builder->build(kThen);
}

CellDescription with_tracker(double u_length_nm, double u_drift_nm_per_h, double u_square_arcsec) {
  CellDescription cell;
  auto& tracker = cell.devices.emplace_back();
  tracker.id = "tracker-x";
  auto& length = tracker.become<LengthSettings>();
  length.channel = {"x", "mm"};
  length.u_length_nm = u_length_nm;
  length.u_drift_nm_per_h = u_drift_nm_per_h;
  if (u_square_arcsec > 0) {
    cell.correction.emplace();
    BeamDescription beam;
    beam.length = {"x", "mm"};
    beam.u_direction_arcsec = u_square_arcsec;
    cell.correction->beams.push_back(beam);
  }
  return cell;
}

compensation::TargetRequest request_at(double x, double y, double z) {
  compensation::TargetRequest request;
  request.set(Variable::x, x), request.set(Variable::y, y), request.set(Variable::z, z);
  set_near(request, "q1_rad", 0.5), set_near(request, "q2_rad", 0.7);
  set_near(request, "q3_rad", -1.2);
  return request;
}

double line_of(const compensation::Budget& budget, UncertaintySource source) {
  for (std::size_t i = 0; i < budget.lines; ++i)
    if (budget.line[i].source == source) return budget.line[i].u_nm;
  return 0;
}

using Error_mm = double (*)(const Dataset&, std::size_t row);
struct Case {
  const char* name;
  UncertaintySource source;
  CellDescription cell;
  std::vector<Error_mm> errors;  // independent, each of one standard uncertainty
};
class ErrorOfTheTracker : public testing::TestWithParam<std::tuple<Case, Datums>> {};

TEST_P(ErrorOfTheTracker, IsInTheBudgetOfEveryJointAsAnotherIdentificationHasIt) {
  const auto& [name, source, cell, errors] = std::get<Case>(GetParam());
  const auto data = rows_of_arm(std::get<Datums>(GetParam()));
  const auto right = served(data, cell), undeclared = served(data, CellDescription{});
  std::vector<Snapshot> others;
  for (const auto error_mm : errors) {
    auto wrong = data;
    for (std::size_t row = 0; row < data.rows; ++row)
      wrong.columns[3].values[row] += error_mm(data, row);
    others.push_back(served(wrong, cell));
  }
  for (const auto& [x, y, z] : {std::array{550.0, 300.0, 420.0}, std::array{300.0, 520.0, 250.0}}) {
    const auto request = request_at(x, y, z);
    const auto target = compute_target(right, request);
    ASSERT_EQ(target.refusal, compensation::Refusal::none) << refusal_error(right, target).message;
    double most_nm = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      double expected_nm = 0;
      for (const auto& other : others)
        expected_nm = std::hypot(expected_nm,
                                 1e6 * (compute_target(other, request).q_mm[j] - target.q_mm[j]));
      most_nm = std::max(most_nm, expected_nm);
      const auto budget = compute_budget(right, request, j);
      EXPECT_NEAR(line_of(budget, source), expected_nm, 0.01 * expected_nm + 0.02) << "joint " << j;
      EXPECT_NEAR(target.u_nm[j], budget.u_nm, 1e-9 * budget.u_nm);
      EXPECT_NEAR(std::hypot(compute_target(undeclared, request).u_nm[j], expected_nm),
                  target.u_nm[j], 0.01 * target.u_nm[j]);
    }
    EXPECT_GT(most_nm, 5) << "1e-6 rad";
  }
}
INSTANTIATE_TEST_SUITE_P(
    Table, ErrorOfTheTracker,
    testing::Combine(testing::Values(Case{"Offset",
                                          UncertaintySource::laser,
                                          with_tracker(2e4, 0, 0),
                                          {[](const Dataset&, std::size_t) { return 2e-2; }}},
                                     Case{"Drift",
                                          UncertaintySource::drift,
                                          with_tracker(0, 1.5e4, 0),
                                          {[](const Dataset& data, std::size_t row) {
                                            return 1.5e-2 * (data.time_s[row] - data.time_s[0]) /
                                                   3600;
                                          }}},
                                     Case{"Square",  // to y and to z
                                          UncertaintySource::beam_direction,
                                          with_tracker(0, 0, 10),
                                          {[](const Dataset& data, std::size_t row) {
                                             return 10 * 4.84813681e-6 *
                                                    data.columns[4].values[row];
                                           },
                                           [](const Dataset& data, std::size_t row) {
                                             return 10 * 4.84813681e-6 *
                                                    data.columns[5].values[row];
                                           }}}),
                     testing::Values(Datums::one, Datums::two)),
    [](const auto& row) {
      return std::get<Case>(row.param).name +
             std::string(std::get<Datums>(row.param) == Datums::one ? "" : "OfTwoDatums");
    });

// Served from rows of two set-ups of the tracker, the tool comes to where it was wanted as the
// first set-up measures it.
TEST(ArmInfluences, AnArmOfTwoDatumsIsServedInTheFirst) {
  const auto one = served(rows_of_arm(Datums::one), CellDescription{}),
             two = served(rows_of_arm(Datums::two), CellDescription{});
  const auto request = request_at(550, 300, 420);
  const auto expected = compute_target(one, request), found = compute_target(two, request);
  ASSERT_EQ(found.refusal, compensation::Refusal::none);
  for (std::size_t j = 0; j < 3; ++j)  // 1 mm at half a metre would be 2000e-6 rad
    EXPECT_NEAR(found.q_mm[j], expected.q_mm[j], 5e-6) << "joint " << j;
}

// The pose of given joints is off by as much as the tracker was.
TEST(ArmInfluences, AnOffsetOfTheTrackerIsAnOffsetOfThePose) {
  const auto data = rows_of_arm();
  compensation::ForwardRequest request;
  request.q_mm = {0.5, 0.7, -1.2};
  const auto plain = forward_pose(served(data, CellDescription{}), request),
             declared = forward_pose(served(data, with_tracker(2e4, 0, 0)), request);
  ASSERT_TRUE(plain) << plain.error().message;
  ASSERT_TRUE(declared) << declared.error().message;
  EXPECT_NEAR(declared->coordinates[0].u, std::hypot(plain->coordinates[0].u, 2e-2), 1e-4);
  EXPECT_NEAR(declared->coordinates[1].u, plain->coordinates[1].u, 1e-5);
}

}  // namespace
}  // namespace driftwise::identification
