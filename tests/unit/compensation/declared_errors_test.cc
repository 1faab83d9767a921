// What the cell declares against the law of propagation worked by hand, and against a fit that was
// given the error.

#include "server/compensation/declared_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/calibration/fit.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/core/units.h"
#include "server/correction/correction.h"
#include "tests/unit/compensation/models.h"

namespace driftwise::compensation {
namespace {

constexpr CellTime kThen{1'300'000'000'000'000'000};

// Two axes that mix, a tilt that follows the pose, a thermometer.
Dataset two_axis_rows() {
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}},      {{"y", "mm"}, {}},
                  {{"z", "mm"}, {}},  {{"ry", "arcsec"}, {}}, {{"t07", "degC"}, {}}};
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 343; ++i) {
    const double x = i % 7 - 3, y = i / 7 % 7 - 3, z = i / 49 - 3,
                 t = 21 + 0.3 * std::sin(0.02 * i);
    const double ry = 10 * x - 4 * z;
    const double values[] = {
        1.01 * x + 0.02 * y + 0.4 * z + 2e-4 * (t - 21) + 2e-6 * normal(random), x, y, z, ry, t};
    for (std::size_t c = 0; c < 6; ++c) data.columns[c].values.push_back(values[c]);
    data.time_s.push_back(20.0 * i);
    ++data.rows;
  }
  return data;
}

calibration::Model fitted(const Dataset& data) {
  calibration::FitOptions options;
  options.select = calibration::Select::all;
  options.candidates.formula = "q1 ~ x + y + z + t07";
  options.candidates.outputs = {"q1"};
  for (const char* symbol : {"x", "y", "z", "t07"})
    options.candidates.terms.push_back(term({power(symbol)}));
  auto model = calibration::fit(data, options);
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

CellDescription three_beam_cell() {
  auto cell = axis_cell();
  for (const char* symbol : {"x", "y", "z"}) {
    DeviceDescription laser;
    laser.id = std::string("laser-") + symbol;
    laser.become<LengthSettings>().channel = {symbol, "mm"};
    cell.devices.push_back(laser);
  }
  cell.correction.emplace();
  for (const char* symbol : {"x", "y", "z"})
    cell.correction->beams.push_back({.length = {symbol, "mm"}});
  return cell;
}

Budget budget_at(const calibration::Model& model, const CellDescription& cell, double x, double y,
                 double z, double* expanded_nm = nullptr) {
  auto builder = SnapshotBuilder::create(model, ModelId{1}, cell);
  EXPECT_TRUE(builder) << builder.error().message;
  builder->keep_model_datum();
  const ChannelValue value{"t07_degC", 21.1};
  builder->observe(std::span(&value, 1), kThen);
  TargetRequest request;
  request.set(Variable::x, x), request.set(Variable::y, y), request.set(Variable::z, z);
  const auto snapshot = builder->build(kThen);
  if (expanded_nm) *expanded_nm = compute_target(snapshot, request).expanded_nm(0);
  return compute_budget(snapshot, request, 0);
}

double line_of(const Budget& budget, UncertaintySource source) {
  for (std::size_t i = 0; i < budget.lines; ++i)
    if (budget.line[i].source == source) return budget.line[i].u_nm;
  return 0;
}

TEST(DeclaredErrors, OfTheLengthAtTheZeroPassThroughTheJacobian) {
  const auto model = fitted(two_axis_rows());
  auto cell = three_beam_cell();
  for (auto& device : cell.devices)
    if (device.length())
      device.become<LengthSettings>().u_length_nm = device.length()->channel.symbol == "z" ? 10 : 5;
  // dq1 = 1.01 dx + 0.02 dy + 0.4 dz
  EXPECT_NEAR(line_of(budget_at(model, cell, 1, 2, -1), UncertaintySource::laser),
              std::hypot(1.01 * 5, 0.02 * 5, 0.4 * 10), 0.01);
}

CellDescription axis_with_laser(double u_length_nm) {
  auto cell = axis_cell();
  auto& laser = cell.devices.emplace_back();
  laser.id = "laser-x";
  laser.become<LengthSettings>().channel = {"x", "mm"};
  laser.become<LengthSettings>().u_length_nm = u_length_nm;
  return cell;
}

// By hand: the noise of the rows has 0.4 of the error of the reading at the zero.
calibration::Model model_with_noise(double kept) {
  auto model = axis_model();
  auto& q1 = model.outputs[0];
  q1.covariance_serial = Eigen::MatrixXd::Zero(5, 5);
  q1.covariance_serial(0, 0) = 1e-10;  // (10 nm)^2, mm^2
  q1.noise_variance = 8e-11;
  const Eigen::VectorXd constant = Eigen::VectorXd::Unit(5, 0);
  q1.influences = {{"x_mm", "1", 1, constant}, {"x_mm", "zero", 0.5, kept * constant}};
  return model;
}

TEST(DeclaredErrors, OfTheReadingAtTheZeroCountOnceWithTheNoiseThatTheRowsHaveOfIt) {
  const auto budget = budget_at(model_with_noise(0.4), axis_with_laser(10), 1, 0, 0);
  // Of the rows' 80 nm^2 the instruments have what is not the robot's own; they are declared with
  // 10^2 + 3^2 nm^2.
  const double own_nm2 = std::pow(line_of(budget, UncertaintySource::residual), 2);
  const double instruments_nm2 = 80 * (1 - own_nm2 / 64);
  const double in_rows_nm = 10 * 0.4 * instruments_nm2 / 109;
  EXPECT_NEAR(line_of(budget, UncertaintySource::laser), 10 - in_rows_nm, 1e-9);
  EXPECT_NEAR(line_of(budget, UncertaintySource::fit), std::sqrt(100 - in_rows_nm * in_rows_nm),
              1e-9);
}

TEST(DeclaredErrors, OfTheReadingAtTheZeroChangeNothingAfterAnotherZero) {
  const auto u_nm = [](double kept) {
    auto model = model_with_noise(kept);
    auto& q1 = model.outputs[0];
    q1.covariance_serial(3, 3) = 1e-10;
    q1.influences[1].shift[3] = kept * 5e-1;
    auto builder = SnapshotBuilder::create(model, ModelId{1}, axis_with_laser(10));
    EXPECT_TRUE(builder) << builder.error().message;
    const std::vector<ChannelValue> then = {{"q1_mm", 1.02}, {"t07_degC", 20.5}};
    const std::vector<ChannelValue> now = {{"t07_degC", 21.5}};
    builder->observe(then, kThen);
    EXPECT_TRUE(builder->anchor(then));
    builder->observe(now, kThen);
    TargetRequest request;
    request.set(Variable::x, 1);
    return compute_target(builder->build(kThen), request).u_nm[0];
  };
  EXPECT_DOUBLE_EQ(u_nm(0.4), u_nm(0));
}

// Slow noise of a fifth of the campaign's length, in the rows and in the zero that they count from,
// against the two lines that state it. They are still wider than the error: the residuals leave
// more slow noise possible than there is.
TEST(DeclaredErrors, OfTheReadingAtTheZeroAreStatedNearerWhereTheNoiseIsSlow) {
  constexpr int kCampaigns = 300, kRows = 400;
  constexpr double kSlow_nm = 7, kWhite_nm = 3;
  double squares = 0, squares_if_independent = 0;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int campaign = 0; campaign < kCampaigns; ++campaign) {
    const double phi = std::exp(-5.0 / kRows);
    double slow_nm = kSlow_nm * normal(random);
    const double at_zero_nm = slow_nm + kWhite_nm * normal(random);
    Dataset data;
    data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t07", "degC"}, {}}};
    for (int i = 0; i < kRows; ++i) {
      slow_nm = phi * slow_nm + std::sqrt(1 - phi * phi) * kSlow_nm * normal(random);
      const double x = i % 7 - 3, t = 21 + 0.5 * std::sin(0.5 * i);
      const double error_nm = slow_nm + kWhite_nm * normal(random) - at_zero_nm;
      data.columns[0].values.push_back(x + 1e-4 * (t - 21));
      data.columns[1].values.push_back(x + 1e-6 * error_nm);
      data.columns[2].values.push_back(t);
      ++data.rows;
    }
    calibration::FitOptions options;
    options.select = calibration::Select::all;
    options.blocks = 0;
    options.candidates.outputs = {"q1"};
    options.candidates.terms = {term({power("x")}), term({power("t07")})};
    auto model = *calibration::fit(data, options);
    const auto ratio2 = [&] {
      auto builder =
          SnapshotBuilder::create(model, ModelId{1}, axis_with_laser(std::hypot(7.0, 3.0)));
      builder->keep_model_datum();
      const ChannelValue value{"t07_degC", 21.1};
      builder->observe(std::span(&value, 1), kThen);
      TargetRequest request;
      request.set(Variable::x, 1);
      const auto snapshot = builder->build(kThen);
      const auto budget = compute_budget(snapshot, request, 0);
      const double error_nm = nm_from_mm(compute_target(snapshot, request).q_mm[0] - 1.00001);
      return std::pow(error_nm, 2) / (std::pow(line_of(budget, UncertaintySource::laser), 2) +
                                      std::pow(line_of(budget, UncertaintySource::fit), 2));
    };
    squares += ratio2();
    model.outputs[0].noise_variance = 0;  // as a model of an earlier version
    squares_if_independent += ratio2();
  }
  const double rms = std::sqrt(squares / kCampaigns),
               if_independent = std::sqrt(squares_if_independent / kCampaigns);
  std::printf("rms of error / line %.3f, as if independent %.3f\n", rms, if_independent);
  EXPECT_LT(rms, 1.05);
  EXPECT_GT(rms, if_independent + 0.025);
}

// A screw at 60 mm from the axis that ry turns about, and how its robot moves sideways with ry.
calibration::OutputModel over_tilts(const Channel& output, double per_arcsec) {
  Dataset data;
  data.columns = {{output, {}}, {{"ry", "arcsec"}, {}}};
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    data.columns[0].values.push_back(per_arcsec * (i % 20 - 10) + 1e-6 * normal(random));
    data.columns[1].values.push_back(i % 20 - 10);
    ++data.rows;
  }
  calibration::FitOptions options;
  options.select = calibration::Select::all;
  options.candidates.outputs = {output.symbol};
  options.candidates.terms = {term({power("ry")})};
  return calibration::fit(data, options)->outputs[0];
}

CellDescription collimated_cell(const std::vector<double>& u_arcsec) {
  auto cell = three_beam_cell();
  for (const double u : u_arcsec) {
    auto& device = cell.devices.emplace_back();
    device.id = "angles " + std::to_string(cell.devices.size());
    auto& angle = device.become<AngleSettings>().angles.emplace_back();
    angle.channel = {"ry", "arcsec"};
    angle.u_arcsec = u;
  }
  return cell;
}

TEST(DeclaredErrors, OfARotationAsACoordinateAreTakenOffTheResidualThroughTheLever) {
  const auto screw = over_tilts({"q1", "mm"}, 60 * kRadPerArcsec);
  const double nm_per_arcsec = 60e6 * kRadPerArcsec;
  const auto noise_nm = [&](const std::vector<double>& u_arcsec) {
    return std::sqrt(instrument_noise_nm2(screw, collimated_cell(u_arcsec), {}));
  };
  constexpr double kScale_nm = 3;  // of q1, axis_cell()
  const double both_nm = std::hypot(kScale_nm, 0.05 * nm_per_arcsec);
  EXPECT_NEAR(noise_nm({0.05}), both_nm, 0.01);
  EXPECT_NEAR(noise_nm({12, 0.05}), both_nm, 0.01) << "the least of several";
  EXPECT_EQ(noise_nm({12, 0}), kScale_nm) << "one of them declares nothing";
}

TEST(DeclaredErrors, OfSeveralInstrumentsAreThoseOfTheOnesThatMeasuredTheRows) {
  const auto screw = over_tilts({"q1", "mm"}, 60 * kRadPerArcsec);
  const auto cell = collimated_cell({12, 0.05});
  const std::string level = cell.devices[cell.devices.size() - 2].id,
                    collimator = cell.devices.back().id;
  const double nm_per_arcsec = 60e6 * kRadPerArcsec;
  constexpr double kScale_nm = 3;  // of q1, axis_cell()
  const auto noise_arcsec = [&](std::vector<MeasuredRows> parts) {
    const double nm2 = instrument_noise_nm2(screw, cell, {{"ry", std::move(parts)}});
    return std::sqrt(nm2 - kScale_nm * kScale_nm) / nm_per_arcsec;
  };
  EXPECT_NEAR(noise_arcsec({{{level}}}), 12, 1e-3);
  EXPECT_NEAR(noise_arcsec({{{collimator}}}), 0.05, 1e-3);
  EXPECT_NEAR(noise_arcsec({{{level, collimator}}}), std::hypot(12, 0.05) / 2, 1e-3)
      << "the mean of a reading of each";
  EXPECT_NEAR(noise_arcsec({{{level}, 50}, {{collimator}, 150}}),
              std::sqrt((50 * 12 * 12 + 150 * 0.05 * 0.05) / 200), 1e-3)
      << "a quarter of the rows by one";
  EXPECT_NEAR(noise_arcsec({{{"sold last year"}}}), 0.05, 1e-3)
      << "an instrument that the cell has no more: the least, as if nothing were stated";
}

TEST(DeclaredErrors, OfTheZeroAreThoseOfTheInstrumentThatMeasuredTheRows) {
  auto cell = three_beam_cell();
  auto& probe = cell.devices.emplace_back();
  probe.id = "probe";
  probe.become<LengthSettings>().channel = {"z", "mm"};
  for (auto& device : cell.devices)
    if (device.length() && device.length()->channel.symbol == "z")
      device.become<LengthSettings>().u_length_nm = device.id == "probe" ? 200 : 10;
  const auto laser_lines = [&](std::vector<MeasuredRows> parts) {
    double squares = 0;
    for (const auto& error : declared_errors(cell, {{"z", std::move(parts)}}))
      if (error.source == UncertaintySource::laser && error.symbol == "z")
        squares += error.u * error.u;
    return std::sqrt(squares);
  };
  EXPECT_NEAR(laser_lines({{{"probe"}}}), 200, 1e-9);
  EXPECT_NEAR(laser_lines({{{"laser-z"}}}), 10, 1e-9);
  EXPECT_NEAR(laser_lines({{{"probe", "laser-z"}}}), std::hypot(100, 5), 1e-9);
}

TEST(DeclaredErrors, OfTheInstrumentThatSawAPredictedMotionAreTakenOffItsResidual) {
  const auto sideways = over_tilts({"x", "mm"}, 0);
  auto cell = collimated_cell({});
  for (auto& device : cell.devices)
    if (device.length() && device.length()->channel.symbol == "x")
      device.become<LengthSettings>().u_length_nm = 10;
  EXPECT_NEAR(instrument_noise_nm2(sideways, cell, {}), 100, 1e-6);
}

TEST(DeclaredErrors, OfALeverArmAreTheTiltThatTheModelSawTimesTheOffset) {
  const auto model = fitted(two_axis_rows());
  auto cell = three_beam_cell();
  cell.correction->beams[0].u_offset_mm = 0.3;  // of x: dx = ry a_z; the data have no rz
  const double ry = 10 * 2 - 4 * -1;
  EXPECT_NEAR(line_of(budget_at(model, cell, 2, 1, -1), UncertaintySource::beam_offset),
              1.01 * 0.3e6 * ry * kRadPerArcsec, 0.05);
  EXPECT_NEAR(line_of(budget_at(model, cell, 0, 1, 0), UncertaintySource::beam_offset), 0, 0.05);
}

CellDescription tilted_cell(double u_arcsec) {
  auto cell = three_beam_cell();
  auto& device = cell.devices.emplace_back();
  device.id = "collimator";
  for (const char* symbol : {"rx", "ry", "rz"}) {
    auto& angle = device.become<AngleSettings>().angles.emplace_back();
    angle.channel = {symbol, "arcsec"};
    angle.u_arcsec = u_arcsec;
  }
  return cell;
}

// Shift of x, y, z, nm, by tilts that are read too large, as the correction itself has it.
Eigen::Vector3d moved_nm(const CellDescription& cell, const correction::Vector3& pose_mm,
                         const correction::Tilt& error) {
  correction::Stage stage;
  for (std::size_t k = 0; k < 3; ++k)
    stage.beams[k] = {cell.correction->beams[k].offset_mm, cell.correction->beams[k].offset_per_mm};
  const auto wrong = correction::pose_from_paths(pose_mm, error, stage),
             right = correction::pose_from_paths(pose_mm, {}, stage);
  Eigen::Vector3d nm;
  for (std::size_t k = 0; k < 3; ++k) nm[static_cast<int>(k)] = nm_from_mm(wrong[k] - right[k]);
  return nm;
}

// q1 = 1.01 x + 0.02 y + 0.4 z by the correction's own errors of each tilt, in squares.
double expected_tilts_nm(const CellDescription& cell, const correction::Vector3& pose_mm,
                         double u_arcsec) {
  const Eigen::RowVector3d slope(1.01, 0.02, 0.4);
  return Eigen::Vector3d(slope * moved_nm(cell, pose_mm, {u_arcsec, 0, 0}),
                         slope * moved_nm(cell, pose_mm, {0, u_arcsec, 0}),
                         slope * moved_nm(cell, pose_mm, {0, 0, u_arcsec}))
      .norm();
}

TEST(DeclaredErrors, OfATiltOnABeamThatIsFixedInTheRoomGrowWithThePose) {
  const auto model = fitted(two_axis_rows());
  auto cell = tilted_cell(0.1);
  cell.correction->beams[0].offset_per_mm = {0, -1, -1};
  for (const auto& [y, z] : {std::pair(0.0, 0.0), std::pair(3.0, 0.0), std::pair(2.0, -3.0)}) {
    const double expected = expected_tilts_nm(cell, {1, y, z}, 0.1);
    EXPECT_NEAR(line_of(budget_at(model, cell, 1, y, z), UncertaintySource::tilts), expected, 0.01);
    if (y == 3.0) {
      EXPECT_NEAR(expected, 1.01 * 3e6 * 0.1 * kRadPerArcsec, 0.001);
    }
  }
}

TEST(DeclaredErrors, OfATiltThatActsOnSeveralLengthsAreOneErrorWithItsSigns) {
  const auto model = fitted(two_axis_rows());
  auto cell = tilted_cell(0.1);
  cell.correction->beams[0].offset_mm = {0, 0, 100};  // x is wrong by -100 mm ry
  cell.correction->beams[2].offset_mm = {100, 0, 0};  // z by +100 mm ry
  const double expected = (1.01 - 0.4) * 100e6 * 0.1 * kRadPerArcsec;
  EXPECT_NEAR(expected_tilts_nm(cell, {1, 2, -1}, 0.1), expected, 0.01);
  EXPECT_NEAR(line_of(budget_at(model, cell, 1, 2, -1), UncertaintySource::tilts), expected, 0.01);
}

TEST(DeclaredErrors, OfATiltAreThoseOfTheInstrumentThatMeasuredTheRows) {
  auto cell = collimated_cell({12, 0.05});
  cell.correction->beams[0].offset_mm = {0, 0, 100};
  const std::string level = cell.devices[cell.devices.size() - 2].id,
                    collimator = cell.devices.back().id;
  const auto arcsec = [&](const std::string& id) {
    double found = 0;
    for (const auto& error : declared_errors(cell, {{"ry", {{{id}}}}}))
      if (error.source == UncertaintySource::tilts && error.symbol == "x") found += error.u;
    return std::abs(found) / (100e6 * kRadPerArcsec);
  };
  EXPECT_NEAR(arcsec(level), 12, 1e-9);
  EXPECT_NEAR(arcsec(collimator), 0.05, 1e-9);
}

TEST(DeclaredErrors, OfABeamsDirectionGrowWithTheOtherAxes) {
  const auto model = fitted(two_axis_rows());
  auto cell = three_beam_cell();
  cell.correction->beams[0].u_direction_arcsec = 5;
  EXPECT_NEAR(line_of(budget_at(model, cell, 3, 2, -1), UncertaintySource::beam_direction),
              1.01 * 1e6 * 5 * kRadPerArcsec * std::hypot(2.0, 1.0), 0.05);
}

TEST(DeclaredErrors, OfAThermometerAreTakenUpByTheConstantWhereItsTermIsLinear) {
  const auto model = fitted(two_axis_rows());
  const auto budget = budget_at(model, three_beam_cell(), 1, 1, 1);  // u_k is 2 mK
  EXPECT_NEAR(line_of(budget, UncertaintySource::temperatures), 0, 1e-4);
}

TEST(DeclaredErrors, OfADriftWithAThermometerGrowWithWhatItHasChangedSinceTheZero) {
  const auto data = two_axis_rows();
  const auto model = fitted(data);
  auto cell = three_beam_cell();
  const auto drifts = [&](const char* symbol, double u_nm_per_k) {
    for (auto& device : cell.devices)
      if (device.length() && device.length()->channel.symbol == symbol) {
        auto& length = device.become<LengthSettings>();
        length.channel = {symbol, "mm"};
        length.u_drift_nm_per_k = u_nm_per_k, length.drift_channel = {"t07", "degC"};
      }
  };
  const double change_k = 21.1 - data.find("t07")->values[0];  // budget_at() is at 21.1
  drifts("x", 50);
  EXPECT_NEAR(line_of(budget_at(model, cell, 1, 2, -1), UncertaintySource::drift),
              1.01 * 50 * change_k, 0.01);
  // One cause: with their signs before they are squared.
  drifts("z", -100);
  EXPECT_NEAR(line_of(budget_at(model, cell, 1, 2, -1), UncertaintySource::drift),
              (1.01 * 50 - 0.4 * 100) * change_k, 0.01);
}

TEST(DeclaredErrors, AddUpToTheExpandedUncertaintyWithTheOtherLines) {
  const auto model = fitted(two_axis_rows());
  auto cell = three_beam_cell();
  for (auto& device : cell.devices)
    if (device.length()) device.settings = LengthSettings{device.length()->channel, 5, 7};
  for (auto& beam : cell.correction->beams)
    beam.u_offset_mm = 0.3, beam.u_direction_arcsec = 2, beam.u_flatness_nm = 10;
  double expanded_nm = 0;
  const auto budget = budget_at(model, cell, 2, -1, 3, &expanded_nm);
  double squares = 0;
  for (std::size_t i = 0; i < budget.lines; ++i) squares += std::pow(budget.line[i].u_nm, 2);
  EXPECT_NEAR(expanded_nm, 2 * std::sqrt(squares), 1e-6 * expanded_nm);
  EXPECT_GT(line_of(budget, UncertaintySource::mirror), 10);
  EXPECT_GT(line_of(budget, UncertaintySource::drift), 1);
}

TEST(DeclaredErrors, AreNoneInACellThatDeclaresNothing) {
  EXPECT_TRUE(declared_errors(CellDescription{}, {}).empty());
}

}  // namespace
}  // namespace driftwise::compensation
