// A robot's geometry becomes a model record, and the record serves: each answer is held against
// homogeneous matrices multiplied in tests/support/kinematics/arm_chain.h.

#include "server/application/models/kinematic_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "server/compensation/snapshot_builder.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/model/model_json.h"
#include "tests/support/kinematics/arm_chain.h"

namespace driftwise::application {
namespace {

using compensation::Variable;
using testing::HasSubstr;

KinematicsDescription drawn_ur10() {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/robots/ur10.toml");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return *formats::parse_robot_file(text, "ur10.toml");
}

KinematicsDescription with_joint_errors(KinematicsDescription arm) {
  arm.links[1].errors.sag_urad_per_m = 1250;
  arm.links[2].errors.sag_urad_per_m = 740;
  arm.links[2].errors.gear_cos1_arcsec = 30;
  return arm;
}

KinematicsDescription ur10_as_built() {
  auto robot = with_joint_errors(drawn_ur10());
  robot.links[1].a_mm -= 1.1;
  robot.links[2].a_mm += 0.5;
  robot.links[3].d_mm += 0.3;
  robot.frame = {.x_mm = 900, .y_mm = -400, .z_mm = 120, .rx_deg = 0.4, .rz_deg = 40};
  return robot;
}

CellDescription cell_of(const KinematicsDescription& robot) {
  CellDescription cell;
  cell.kinematics = robot;
  return cell;
}

Result<KinematicFit> imported(const KinematicsDescription& robot, const CellDescription& cell) {
  KinematicRequest request;
  request.robot = formats::write_robot_file(robot);
  return kinematic_record(std::nullopt, request, cell);
}

TEST(KinematicRecord, OfAnArmIsIdentifiedAndServesToANanometre) {
  KinematicRequest request;
  request.robot = formats::write_robot_file(with_joint_errors(drawn_ur10()));
  request.fit.csv = tests::measured_csv(ur10_as_built(), 160);
  const auto data = formats::read_dataset_csv(request.fit.csv, "tracker.csv");
  ASSERT_TRUE(data) << data.error().message;
  const auto made = kinematic_record(*data, request, cell_of(drawn_ur10()));
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(formats::stored_model_hash(made->model.json).value_or(""), made->model.hash);
  const auto model = formats::read_model_json(made->model.json);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(formats::write_model_json(*model), made->model.json);
  EXPECT_EQ(model->lineage.rows_calibration, 120);
  EXPECT_EQ(model->lineage.rows_validation, 40);
  for (const auto& output : model->outputs)  // 20 um on rows that it did not see
    EXPECT_NEAR(*output.accuracy.a90_validation, 1.645 * 0.02, 0.012) << output.channel.name();
  const auto& robot = model->geometry->robot;
  EXPECT_NEAR(robot.links[1].a_mm, -613.1, 0.05);
  EXPECT_EQ(robot.links[1].errors.sag_urad_per_m, 1250);

  auto builder = compensation::SnapshotBuilder::create(*model, ModelId{1}, CellDescription{});
  ASSERT_TRUE(builder) << builder.error().message;
  const auto snapshot = builder->build(CellTime{1'000'000'000});
  const std::vector<double> q = {0.3, -1.2, 1.4, -1.0, 1.1, 0.5};
  const auto wanted = tests::forward(robot, q, 20);
  const auto turns = tests::rotations_arcsec(wanted);
  compensation::TargetRequest asked;
  asked.set(Variable::x, wanted(0, 3));
  asked.set(Variable::y, wanted(1, 3));
  asked.set(Variable::z, wanted(2, 3));
  asked.set(Variable::rx, turns[0]);
  asked.set(Variable::ry, turns[1]);
  asked.set(Variable::rz, turns[2]);
  for (std::size_t j = 0; j < 6; ++j)
    compensation::set_near(asked, "q" + std::to_string(j + 1) + "_rad", q[j] + 0.001);
  const auto target = compensation::compute_target(snapshot, asked);
  ASSERT_EQ(target.refusal, compensation::Refusal::none)
      << compensation::refusal_error(snapshot, target).message;
  const auto reached = tests::forward(robot, {target.q_mm.begin(), target.q_mm.begin() + 6}, 20);
  EXPECT_LT((reached - wanted).block(0, 3, 3, 1).norm() * 1e6, 1);
  EXPECT_EQ(target.flags & compensation::kUnjudgedModel, 0u);
  for (std::size_t j = 0; j < 6; ++j) {  // some 20 um at up to a metre; short levers at the wrist
    EXPECT_GT(target.u_nm[j], 1) << "urad";
    EXPECT_LT(target.u_nm[j], 1000) << "urad";
  }
}

TEST(KinematicRecord, OfADeltaTakesTemperaturesInBesideTheGeometry) {
  KinematicsDescription delta;
  delta.kind = "delta-vertical";
  delta.hold = {"*.scale_ppm", "*.tilt_*", "frame.*", "*.azimuth_deg"};
  for (int i = 0; i < 3; ++i)
    delta.branches.push_back({.motor = {"q" + std::to_string(i + 1), "mm"},
                              .azimuth_deg = 120.0 * i,
                              .radius_mm = 40,
                              .length_mm = 70});
  // Closed by hand: vertical axes, so q = z - h + sqrt(L^2 - horizontal distance squared).
  const auto motor = [](int i, double x, double y, double z, double t_degc) {
    const double a = 120.0 * i * tests::kDeg, radius = 40.05, length = 70.1;
    const double dx = x - radius * std::cos(a), dy = y - radius * std::sin(a);
    return z - std::sqrt(length * length - radius * radius) +
           std::sqrt(length * length - dx * dx - dy * dy) + 2e-4 * (i + 1) * (t_degc - 20);
  };
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-2, 2), warm(20, 23);
  std::normal_distribution<double> noise_mm(0, 1e-5);
  std::ostringstream csv;
  csv.precision(17);
  csv << "time_s,q1_mm,q2_mm,q3_mm,x_mm,y_mm,z_mm,t05_degC\n";
  for (int row = 0; row < 120; ++row) {
    const double x = place(random), y = place(random), z = place(random), t = warm(random);
    csv << 10 * row;
    for (int i = 0; i < 3; ++i) csv << ',' << motor(i, x, y, z, t) + noise_mm(random);
    csv << ',' << x << ',' << y << ',' << z << ',' << t << '\n';
  }
  KinematicRequest request;
  request.fit.csv = csv.str();
  request.fit.formula = "q1 + q2 + q3 ~ t05";
  const auto data = formats::read_dataset_csv(request.fit.csv, "delta.csv");
  const auto made = kinematic_record(*data, request, cell_of(delta));
  ASSERT_TRUE(made) << made.error().message;
  auto model = formats::read_model_json(made->model.json);
  ASSERT_TRUE(model) << model.error().message;
  for (const auto& output : model->outputs) {  // rows are independent; t05 is uniform over 3 K
    EXPECT_NEAR(output.accuracy.lag1_autocorrelation, 0, 0.25) << output.channel.name();
    const auto& warmth = output.report.back();
    EXPECT_NEAR(warmth.contribution_rms, std::abs(warmth.coefficient) * 3 / std::sqrt(12),
                0.1 * std::abs(warmth.coefficient));
    EXPECT_NEAR(warmth.contribution_max, std::abs(warmth.coefficient) * 1.5,
                0.25 * std::abs(warmth.coefficient));
  }
  auto builder = compensation::SnapshotBuilder::create(*model, ModelId{1}, CellDescription{});
  ASSERT_TRUE(builder) << builder.error().message;
  builder->keep_model_datum();
  const ChannelValue warm_now{"t05_degC", 22.5};
  builder->observe({&warm_now, 1}, CellTime{1'000'000'000});
  const auto snapshot = builder->build(CellTime{1'000'000'000});
  compensation::TargetRequest asked;
  asked.set(Variable::x, 1.1);
  asked.set(Variable::y, -0.7);
  asked.set(Variable::z, 0.4);
  const auto target = compensation::compute_target(snapshot, asked);
  ASSERT_EQ(target.refusal, compensation::Refusal::none);
  EXPECT_EQ(target.flags & (compensation::kUnjudgedModel | compensation::kMissingTemperature), 0u);
  for (std::size_t i = 0; i < 3; ++i) {
    const double error_nm =
        1e6 * (target.q_mm[i] - motor(static_cast<int>(i), 1.1, -0.7, 0.4, 22.5));
    EXPECT_LT(std::abs(error_nm), 4 * target.u_nm[i]) << target.u_nm[i];
    EXPECT_GT(target.u_nm[i], 5) << "10 nm of noise";
    EXPECT_LT(target.u_nm[i], 40);
  }
}

// A file whose laser counts the other way: the axis would have a scale of -2000020 ppm, which no
// robot file may state, so a model of it could not be read again.
TEST(KinematicRecord, OfRowsWithTheOtherSignIsRefusedBeforeItIsStored) {
  KinematicsDescription axis;
  axis.kind = "linear-axis";
  axis.axes = {{.motor = {"q1", "mm"}, .pose = {"x", "mm"}}};
  std::mt19937 random(6);
  std::normal_distribution<double> noise_mm(0, 1e-6);
  for (const double sign : {1.0, -1.0}) {
    std::ostringstream csv;
    csv.precision(12);
    csv << "time_s,q1_mm,x_mm\n";
    for (int row = 0; row < 60; ++row) {
      const double x_mm = -4 + 8 * std::fmod(row * 0.618, 1.0);
      csv << 20 * row << ',' << sign * 1.00002 * x_mm + noise_mm(random) << ',' << x_mm << '\n';
    }
    KinematicRequest request;
    request.fit.csv = csv.str();
    const auto data = formats::read_dataset_csv(request.fit.csv, "rev.csv");
    const auto made = kinematic_record(*data, request, cell_of(axis));
    if (sign > 0) {
      ASSERT_TRUE(made) << made.error().message;
      continue;
    }
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::failed_precondition);
    EXPECT_EQ(made.error().reason, "BAD_KINEMATICS");
    for (const char* told : {"scale_ppm", "-20000", "60 rows", "signs", "order of the motors"})
      EXPECT_THAT(made.error().message, HasSubstr(told));
  }
}

// Two files of a tracker that was set up again in between, 1 mm further on in x: what serves and
// what a robot file says is the arm as the first of them saw it.
TEST(KinematicRecord, OfAnArmOnTwoDatumsStandsInTheFirst) {
  KinematicRequest request;
  request.robot = formats::write_robot_file(with_joint_errors(drawn_ur10()));
  request.fit.csv = tests::measured_csv(ur10_as_built(), 160);
  auto data = *formats::read_dataset_csv(request.fit.csv, "tracker.csv");
  data.datum.assign(data.rows, 1);
  for (std::size_t row = 80; row < data.rows; ++row) {
    data.datum[row] = 2;
    const auto x = std::ranges::find(data.columns, "x", [](const auto& one) -> const std::string& {
      return one.channel.symbol;
    });
    x->values[row] += 1;
  }
  const auto made = kinematic_record(data, request, cell_of(drawn_ur10()));
  ASSERT_TRUE(made) << made.error().message;
  const auto model = formats::read_model_json(made->model.json);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_NEAR(model->geometry->robot.frame.x_mm, 900, 0.05);
  for (const auto& output : model->outputs) {
    EXPECT_TRUE(output.terms[0].is_constant());
    EXPECT_EQ(output.coefficients[0], 0) << output.channel.name();
    EXPECT_NEAR(output.coefficients[1], output.channel.symbol == "x" ? 1 : 0, 0.03);
  }
  EXPECT_TRUE(compensation::SnapshotBuilder::create(*model, ModelId{1}, CellDescription{}));
  const std::vector<double> q = {0.3, -1.2, 1.4, -1.0, 1.1, 0.5};
  const auto truth = tests::forward(ur10_as_built(), q, 20),
             stated = tests::forward(model->geometry->robot, q, 20);
  EXPECT_LT((stated - truth).block(0, 3, 3, 1).norm(), 0.03) << "20 um of noise over 60 rows";
}

TEST(KinematicRecord, OfAnImportedFileHasNoFigures) {
  const auto made = imported(with_joint_errors(drawn_ur10()), cell_of(drawn_ur10()));
  ASSERT_TRUE(made) << made.error().message;
  const auto model = formats::read_model_json(made->model.json);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_TRUE(model->outputs.empty());
  EXPECT_EQ(model->geometry->covariance.size(), 0);
  EXPECT_EQ(model->geometry->robot.links[2].errors.gear_cos1_arcsec, 30);
}

TEST(KinematicRecord, OfAnotherRobotIsRefusedWithWhatDiffers) {
  const auto cell = cell_of(drawn_ur10());
  const auto refusal = [&](const KinematicsDescription& robot) {
    const auto made = imported(robot, cell);
    if (made) return std::string("stored");
    EXPECT_EQ(made.error().reason, "OTHER_ROBOT");
    return made.error().message;
  };
  auto other = drawn_ur10();
  other.links[1].a_mm = -425;  // a UR5's upper arm
  EXPECT_THAT(refusal(other), HasSubstr("link2.a_mm is -425, in the cell's drawing -612"));
  other = drawn_ur10();
  other.links[4].alpha_deg = 90;
  EXPECT_THAT(refusal(other), HasSubstr("link5.alpha_deg"));
  other = drawn_ur10();
  other.links.pop_back();
  EXPECT_THAT(refusal(other), HasSubstr("expected q1_rad, q2_rad"));
  other = drawn_ur10();
  other.links[3].motor = {"q4", "deg"};
  EXPECT_THAT(refusal(other), HasSubstr("q4_deg"));
  other = drawn_ur10();
  other.frame.x_mm = 3000;  // where it stands is no question of which robot it is
  other.tool_z_mm = 50;
  other.links[0].theta_deg += 3;  // nor is where its joints read zero
  other.links[2].theta_deg += 1.5;
  EXPECT_EQ(refusal(other), "stored");
  EXPECT_EQ(imported(drawn_ur10(), CellDescription{}).error().reason, "NO_KINEMATICS");
}

TEST(KinematicRecord, WithAMotorThatTheCellHasNoAxisForIsRefused) {
  KinematicsDescription axis;
  axis.kind = "linear-axis";
  axis.axes = {{.motor = {"q1", "mm"}, .pose = {"x", "mm"}}};
  auto cell = cell_of(axis);
  DeviceDescription device;
  device.become<MotionSettings>().axes = {
      {.channel = {"q2", "mm"}, .device_axis = "Y", .min_mm = -1, .max_mm = 1}};
  cell.devices = {device};
  const auto made = imported(axis, cell);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, HasSubstr("the cell has no axis q1_mm, only q2_mm"));
}

}  // namespace
}  // namespace driftwise::application
