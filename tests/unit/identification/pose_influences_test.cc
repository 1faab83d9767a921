// A systematic error of the measured pose against what its influence says: the oracle is another
// identification, with the error in the data; of an axis, a regression of the same rows.

#include "server/identification/pose_influences.h"

#include <gtest/gtest.h>

#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/model_json.h"
#include "server/identification/pose_rows.h"
#include "server/kinematics/drawing.h"
#include "tests/unit/identification/robots.h"

namespace driftwise::identification {
namespace {

using compensation::UncertaintySource;
using compensation::Variable;

constexpr CellTime kThen{1'300'000'000'000'000'000};

effects::Term linear_in(const char* symbol) { return {{effects::Power{symbol, 1}}}; }

KinematicsDescription held_delta() {
  auto delta = robots::nominal_delta();
  delta.hold = {"*.scale_ppm", "*.tilt_*", "frame.*", "*.azimuth_deg"};
  return delta;
}

// With a tilt that follows the pose.
Dataset delta_rows() {
  auto built = held_delta();
  built.branches[0].radius_mm += 0.05;
  built.branches[1].length_mm -= 0.03;
  auto data = robots::delta_campaign(built, 6, {1e-6, 2e-4, 1e-4}, 3);
  data.columns.push_back({{"ry", "arcsec"}, {}});
  for (std::size_t row = 0; row < data.rows; ++row)
    data.columns.back().values.push_back(20 * data.columns[0].values[row] -
                                         7 * data.columns[2].values[row] *
                                             data.columns[2].values[row]);
  return data;
}

Identification identified(const Dataset& data) {
  const auto found = identify(data, {.mechanism = *kinematics::make_mechanism(held_delta()),
                                     .terms = {linear_in("t05"), linear_in("force")}});
  EXPECT_TRUE(found) << found.error().message;
  return *found;
}

// x wrong by so many mm times a channel, or hours, or 1.
Dataset with_error(Dataset data, const std::string& by, double size) {
  const auto* column = data.find(by.substr(0, by.find('_')));
  for (std::size_t row = 0; row < data.rows; ++row) {
    const double shape = by == "1"          ? 1
                         : by == "h"        ? (data.time_s[row] - data.time_s[0]) / 3600
                         : by == "t05_degC" ? column->values[row] - column->values[0]
                                            : column->values[row];
    data.columns[0].values[row] += size * shape;
  }
  return data;
}

struct Case {
  const char *name, *by;
  double size;  // mm per unit of it
};
class ErrorOfThePose : public testing::TestWithParam<Case> {};

TEST_P(ErrorOfThePose, HasTheInfluenceThatAnotherIdentificationShows) {
  const auto& [name, by, size] = GetParam();
  const auto data = delta_rows();
  const auto before = identified(data), after = identified(with_error(data, by, size));
  const auto influences = pose_influences(data, before);
  ASSERT_TRUE(influences) << influences.error().message;
  const auto one = std::ranges::find_if(
      *influences, [&](const auto& it) { return it.channel == "x_mm" && it.by == by; });
  ASSERT_NE(one, influences->end());
  auto expected = before;
  Eigen::Index k = 0;
  for (auto& parameter : expected.parameters)
    if (parameter.free) parameter.value -= size * one->parameters[k++];
  expected.coefficients -= size * one->coefficients;
  const Eigen::MatrixXd right = *predict(data, before), served = *predict(data, after),
                        stated = *predict(data, expected);
  EXPECT_GT((served - right).norm(), 1e-7);
  EXPECT_LT((served - stated).norm(), 2e-3 * (served - right).norm());
}
INSTANTIATE_TEST_SUITE_P(Table, ErrorOfThePose,
                         testing::Values(Case{"Offset", "1", 1e-4}, Case{"Factor", "x_mm", 1e-5},
                                         Case{"Neighbour", "y_mm", 1e-5},
                                         Case{"LeverArm", "ry_arcsec", 1e-6},
                                         Case{"Drift", "h", 1e-4},
                                         Case{"DriftWithTheRoom", "t05_degC", 5e-5}),
                         [](const auto& row) { return std::string(row.param.name); });

// As kinematic_record() fills it.
calibration::Model model_of(const Dataset& data, const Identification& found) {
  calibration::Model model;
  calibration::Geometry geometry{
      kinematics::with_values(*found.mechanism, found.values()), {}, found.covariance};
  for (const auto& [parameter, value, error, free, note] : found.parameters)
    geometry.parameters.push_back({parameter.name, value, error, free, note});
  model.geometry = std::move(geometry);
  for (std::size_t o = 0; o < found.mechanism->outputs().size(); ++o) {
    auto& output = model.outputs.emplace_back();
    output.channel = found.mechanism->outputs()[o];
    output.dof = static_cast<int>(found.rows) - found.unknowns;
    output.terms = found.terms;
    const auto count = static_cast<Eigen::Index>(found.terms.size());
    output.coefficients = Eigen::VectorXd::Zero(count);
    output.covariance = Eigen::MatrixXd::Zero(count, count);
    if (count == 0) continue;
    output.coefficients = found.coefficients.col(static_cast<Eigen::Index>(o));
    output.covariance = found.term_covariances[o];
  }
  for (const auto& column : data.columns) {
    const auto [low, high] = std::ranges::minmax(column.values);
    model.domain.push_back({column.channel, low, high});
  }
  const auto added = add_pose_influences(data, found, model);
  EXPECT_TRUE(added) << added.error().message;
  return model;
}

double line_of(const compensation::Budget& budget, UncertaintySource source) {
  for (std::size_t i = 0; i < budget.lines; ++i)
    if (budget.line[i].source == source) return budget.line[i].u_nm;
  return 0;
}

// The drift of x is taken up by the geometry and by the term of the thermometer, which goes the
// same way as the room: both parts are one error.
TEST(PoseInfluences, OfADriftAreInTheBudgetOfADeltaWithTheSignsOfGeometryAndTerms) {
  const auto data = delta_rows();
  const auto before = identified(data);
  constexpr double kDrift_nm_per_k = 50;
  const Eigen::MatrixXd error =
      *predict(data, identified(with_error(data, "t05_degC", 1e-6 * kDrift_nm_per_k))) -
      *predict(data, before);
  CellDescription cell;
  auto& laser = cell.devices.emplace_back();
  laser.id = "laser-x";
  auto& length = laser.become<LengthSettings>();
  length.channel = {"x", "mm"};
  length.u_drift_nm_per_k = kDrift_nm_per_k, length.drift_channel = {"t05", "degC"};
  auto builder = compensation::SnapshotBuilder::create(model_of(data, before), ModelId{1}, cell);
  ASSERT_TRUE(builder) << builder.error().message;
  builder->keep_model_datum();
  for (const std::size_t row : {0u, 100u, 215u}) {
    const ChannelValue room{"t05_degC", data.find("t05")->values[row]};
    builder->observe(std::span(&room, 1), kThen);
    const auto snapshot = builder->build(kThen);
    compensation::TargetRequest request;
    request.set(Variable::x, data.columns[0].values[row]);
    request.set(Variable::y, data.columns[1].values[row]);
    request.set(Variable::z, data.columns[2].values[row]);
    request.set(Variable::force, data.find("force")->values[row]);
    const auto target = compute_target(snapshot, request);
    ASSERT_EQ(target.refusal, compensation::Refusal::none);
    for (std::size_t o = 0; o < 3; ++o) {
      const auto budget = compute_budget(snapshot, request, o);
      const double expected_nm =
          std::abs(1e6 * error(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(o)));
      EXPECT_NEAR(line_of(budget, UncertaintySource::drift), expected_nm, 0.01 * expected_nm + 0.02)
          << "row " << row << ", motor " << o + 1;
      EXPECT_NEAR(target.u_nm[o], budget.u_nm, 1e-9 * budget.u_nm);
    }
  }
}

// q1 = 1.00002 x: a straight line and a linear axis are one model.
struct TwoModels {
  calibration::Model regression, geometry;
};
TwoModels axis_models() {
  Dataset data;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"rz", "arcsec"}, {}}};
  data.rows = 300;
  for (int i = 0; i < 300; ++i) {
    const double x = -4 + 8 * std::fmod(i * 0.618, 1.0);
    data.time_s.push_back(30.0 * i);
    data.columns[0].values.push_back(1.00002 * x + 2e-6 * normal(random));
    data.columns[1].values.push_back(x);
    data.columns[2].values.push_back(20 * x);
  }
  calibration::FitOptions options;
  options.select = calibration::Select::all;
  KinematicsDescription axis;
  axis.kind = "linear-axis";
  axis.axes.push_back({.motor = {"q1", "mm"}, .pose = {"x", "mm"}});
  const auto found = identify(data, {.mechanism = *kinematics::make_mechanism(axis), .terms = {}});
  EXPECT_TRUE(found) << found.error().message;
  return {*formats::fit_formula(data, "q1 ~ x", options), model_of(data, *found)};
}

CellDescription declared_axis() {
  CellDescription cell;
  auto& laser = cell.devices.emplace_back();
  laser.id = "laser-x";
  auto& length = laser.become<LengthSettings>();
  length.channel = {"x", "mm"};
  length.u_drift_nm_per_h = 20;
  cell.correction.emplace();
  BeamDescription beam;
  beam.length = {"x", "mm"};
  beam.u_offset_mm = 0.3;
  beam.u_flatness_nm = 2.5;
  cell.correction->beams.push_back(beam);
  return cell;
}

TEST(PoseInfluences, OfALinearAxisGiveTheLinesOfTheRegressionOfTheSameRows) {
  const auto [regression, geometry] = axis_models();
  for (const bool carried : {false, true}) {
    const auto budget = [&](const calibration::Model& model) {
      auto builder = compensation::SnapshotBuilder::create(model, ModelId{1}, declared_axis());
      EXPECT_TRUE(builder) << builder.error().message;
      const ChannelValue zero{"q1_mm", 0.0};
      if (carried)
        EXPECT_TRUE(builder->anchor(std::span(&zero, 1)));
      else
        builder->keep_model_datum();
      compensation::TargetRequest request;
      request.set(Variable::x, 3.9);
      return compute_budget(builder->build(kThen), request, 0);
    };
    const auto expected = budget(regression), found = budget(geometry);
    for (const auto source :
         {UncertaintySource::beam_offset, UncertaintySource::drift, UncertaintySource::mirror})
      EXPECT_NEAR(line_of(found, source), line_of(expected, source),
                  1e-3 * line_of(expected, source) + 1e-6)
          << to_string(source) << (carried ? ", carried" : "");
    EXPECT_GT(line_of(found, UncertaintySource::beam_offset), 100) << "0.3 mm at 78 arcsec";
  }
}

TEST(PoseInfluences, AreInTheModelsJson) {
  const auto model = axis_models().geometry;
  const auto back = formats::read_model_json(formats::write_model_json(model));
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_GT(model.geometry->influences.size(), 3u);
  ASSERT_EQ(back->geometry->influences.size(), model.geometry->influences.size());
  ASSERT_EQ(back->outputs[0].influences.size(), model.geometry->influences.size());
  for (std::size_t k = 0; k < model.geometry->influences.size(); ++k) {
    EXPECT_EQ(back->geometry->influences[k].by, model.geometry->influences[k].by);
    EXPECT_EQ(back->geometry->influences[k].shift, model.geometry->influences[k].shift);
  }
}

}  // namespace
}  // namespace driftwise::identification
