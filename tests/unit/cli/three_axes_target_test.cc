// A robot of three axes under force: a model with three outputs gives the same q1, q2, q3 by gRPC,
// command line and text line to the last digit, and as an exported C function; the budget stands
// for each of them.

#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <fstream>

#include "driftwise/v1/target_service.grpc.pb.h"
#include "server/compensation/snapshot_builder.h"
#include "server/formats/export/model_c.h"
#include "server/formats/export/target_line.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

effects::Term product_of(std::vector<effects::Power> powers) {
  effects::Term term;
  for (auto& power : powers) term.factors.emplace_back(std::move(power));
  return term;
}

// Each output its own terms and coefficients, of pose, force and two thermometers.
calibration::Model three_axis_model() {
  calibration::Model model;
  model.formula = "q ~ poly(x, y, z, 3) + F + t05 + t06";
  const std::vector<effects::Term> terms = {
      {},
      product_of({{"x", 1}}),
      product_of({{"y", 1}}),
      product_of({{"z", 1}}),
      product_of({{"x", 2}, {"y", 1}}),
      product_of({{"x", 1}, {"z", 1}}),
      product_of({{"force", 1}}),
      product_of({{"force", 3}}),
      product_of({{"t05", 1}}),
      product_of({{"t06", 1}}),
  };
  for (int axis = 1; axis <= 3; ++axis) {
    calibration::OutputModel output;
    output.channel = {"q" + std::to_string(axis), "mm"};
    for (std::size_t k = 0; k < terms.size(); ++k)
      if (k != static_cast<std::size_t>(3 + axis)) output.terms.push_back(terms[k]);
    const auto count = static_cast<Eigen::Index>(output.terms.size());
    output.coefficients.resize(count);
    for (Eigen::Index k = 0; k < count; ++k)
      output.coefficients[k] = (k < 4 ? 0.37 : 1.3e-4) * (1 + 0.1 * axis) / (1.0 + 0.7 * double(k));
    output.covariance = Eigen::MatrixXd::Identity(count, count) * 1e-13;
    output.accuracy.rmse = 2e-5 + 1e-6 * axis;
    model.outputs.push_back(std::move(output));
  }
  model.domain = {{{"x", "mm"}, 0, 2.5},    {{"y", "mm"}, 0, 2.5},     {{"z", "mm"}, 0, 2.5},
                  {{"force", "N"}, 0, 2.5}, {{"t05", "degC"}, 20, 24}, {{"t06", "degC"}, 20, 24}};
  return model;
}

struct Pose {
  double x, y, z, force;
  compensation::TargetRequest request() const {
    using compensation::Variable;
    compensation::TargetRequest out;
    out.set(Variable::x, x), out.set(Variable::y, y), out.set(Variable::z, z);
    out.set(Variable::force, force);
    return out;
  }
};
constexpr Pose kPose{1.2345678, 0.3456789, 2.4567891, 0.3924};
constexpr double kT05_degc = 21.125, kT06_degc = 22.5;

class ThreeAxes : public CliTest {
 protected:
  ThreeAxes() {
    fakes.targets = &targets;
    serve(three_axis_model());
  }
  void serve(calibration::Model model) {
    CellDescription description;
    auto builder = compensation::SnapshotBuilder::create(std::move(model), ModelId{1}, description);
    if (!builder) throw std::runtime_error(builder.error().message);
    builder->keep_model_datum();
    const std::vector<ChannelValue> values = {{"t05_degC", kT05_degc}, {"t06_degC", kT06_degc}};
    const CellTime now = cell.now();
    cell.on_executor([&] {
      builder->observe(values, now);
      snapshot = builder->build(now);
      targets.publish(snapshot);
    });
    expected = compensation::compute_target(snapshot, kPose.request());
  }
  std::vector<std::string> words(const std::string& verb) const {
    return {verb, "x=1.2345678", "y=0.3456789", "z=2.4567891", "force=0.3924"};
  }
  FakeTargets targets;
  compensation::Snapshot snapshot;
  compensation::Target expected;
};

TEST_F(ThreeAxes, GetTheSameTargetByCommandLineAndGrpc) {
  ASSERT_EQ(expected.outputs, 3U);
  const auto shown = json(words("target"))["coordinates"];
  v1::ComputeTargetRequest request;
  for (const auto& [channel, value] : {std::pair{"x_mm", kPose.x},
                                       {"y_mm", kPose.y},
                                       {"z_mm", kPose.z},
                                       {"force_N", kPose.force}}) {
    auto& added = *request.add_pose();
    added.set_channel(channel);
    added.set_value(value);
  }
  grpc::ClientContext context;
  v1::ComputeTargetResponse response;
  const auto channel = grpc::CreateChannel(server->address(), grpc::InsecureChannelCredentials());
  ASSERT_TRUE(
      v1::TargetService::NewStub(channel)->ComputeTarget(&context, request, &response).ok());
  ASSERT_EQ(shown.size(), 3U);
  ASSERT_EQ(response.target().coordinates_size(), 3);
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    EXPECT_EQ(shown[at]["channel"], "q" + std::to_string(i + 1) + "_mm");
    EXPECT_EQ(shown[at]["position_mm"].get<double>(), expected.q_mm[at]);
    EXPECT_EQ(response.target().coordinates(i).position_mm(), expected.q_mm[at]);
    EXPECT_EQ(response.target().coordinates(i).expanded_nm(), expected.expanded_nm(at));
  }
}

// A motor coordinate of such a robot stands beside no coordinate of the pose.
TEST_F(ThreeAxes, ShowTheCorrectionThatTheDaemonTells) {
  const auto shown = json(words("target"))["coordinates"];
  const auto page = run(words("target")).out;
  EXPECT_THAT(page, HasSubstr("correction nm"));
  for (const auto& one : shown) {
    const auto position = fmt::format("{:.7f}", one["position_mm"].get<double>());
    const auto from = page.find(position);
    ASSERT_NE(from, std::string::npos) << page;
    const auto cells = page.substr(from + position.size(), page.find('\n', from) - from);
    const auto at = cells.find_first_not_of(' ');
    const auto correction = cells.substr(at, cells.find(' ', at) - at);
    EXPECT_EQ(correction, one.contains("correction_nm") && !one["correction_nm"].is_null()
                              ? fmt::format("{:+.1f}", one["correction_nm"].get<double>())
                              : "-");
  }
}

TEST_F(ThreeAxes, GetTheSameTargetByTextLine) {
  const auto request = formats::parse_target_line(
      "TARGET x_mm=1.2345678 y_mm=0.3456789 z_mm=2.4567891 force_N=0.3924 u=1");
  ASSERT_TRUE(request) << request.error().message;
  std::string answer;
  formats::append_target_answer(answer, snapshot, compensation::compute_target(snapshot, *request),
                                true);
  std::array<double, 3> q{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string name = " q" + std::to_string(i + 1) + "_mm=";
    const auto from = answer.find(name);
    ASSERT_NE(from, std::string::npos) << answer;
    q[i] = std::stod(answer.substr(from + name.size()));
    EXPECT_EQ(q[i], expected.q_mm[i]);
  }
}

// The C function multiplies the terms out one by one: the last digit may differ from the fold.
TEST_F(ThreeAxes, GetTheSameTargetFromTheExportedFunction) {
  const auto source = formats::write_model_c(three_axis_model(), "delta");
  ASSERT_TRUE(source) << source.error().message;
  std::ofstream(folder.path() + "/model.c")
      << *source
      << "#include <stdio.h>\nint main(void) {\n  const double pose[4] = {1.2345678, 0.3456789, "
         "2.4567891, 0.3924}, t[2] = {21.125, 22.5};\n  double q[3];\n  int outside = "
         "driftwise_model_delta(pose, t, q);\n  printf(\"[%.17g, %.17g, %.17g, %d]\", q[0], q[1], "
         "q[2], outside);\n  return 0;\n}\n";
  const auto compiled = run_process({"/usr/bin/cc", "-std=c99", "-O2", "-o",
                                     folder.path() + "/model", folder.path() + "/model.c"},
                                    std::chrono::seconds(60), {});
  ASSERT_EQ(compiled.code, 0) << compiled.err;
  const auto printed = run_process({folder.path() + "/model"}, std::chrono::seconds(60), {});
  ASSERT_EQ(printed.code, 0);
  const auto numbers = nlohmann::json::parse(printed.out);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(numbers[i].get<double>(), expected.q_mm[i], 1e-14);
  EXPECT_EQ(numbers[3], 0);
}

TEST_F(ThreeAxes, AreSimulatedWhereTheirTargetWasAskedFor) {
  auto model = three_axis_model();
  for (Eigen::Index axis = 0; axis < 3; ++axis)  // each motor mostly along its own coordinate
    model.outputs[static_cast<std::size_t>(axis)].coefficients[1 + axis] += 1;
  serve(model);
  std::vector<std::string> words = {"simulate", "force=0.3924"};
  for (std::size_t i = 0; i < 3; ++i)
    words.push_back(fmt::format("q{}={:.17g}", i + 1, expected.q_mm[i]));
  const auto shown = json(words);
  ASSERT_EQ(shown["coordinates"].size(), 3U);
  EXPECT_NEAR(shown["coordinates"][0]["value"].get<double>(), kPose.x, 1e-9);
  EXPECT_NEAR(shown["coordinates"][1]["value"].get<double>(), kPose.y, 1e-9);
  EXPECT_NEAR(shown["coordinates"][2]["value"].get<double>(), kPose.z, 1e-9);
  EXPECT_TRUE(shown["coordinates"][0]["measured"].is_null()) << "these are not the motors of now";
  EXPECT_THAT(run(words).out, HasSubstr("q3_mm"));
  words.pop_back();
  EXPECT_THAT(run(words).err, HasSubstr("q3_mm is missing"));
  EXPECT_THAT(run({"simulate", "q9=1"}).err, HasSubstr("no motor coordinate of model 1"));
}

TEST_F(ThreeAxes, ShowABudgetForEach) {
  auto arguments = words("target");
  arguments.emplace_back("--budget");
  const auto shown = json(arguments)["coordinates"];
  for (std::size_t i = 0; i < 3; ++i) {
    double squares = 0;
    for (const auto& line : shown[i]["budget"]) squares += std::pow(line["u_nm"].get<double>(), 2);
    EXPECT_NEAR(std::sqrt(squares), expected.u_nm[i], 1e-9);
  }
  const auto page = run(arguments);
  EXPECT_THAT(page.out, HasSubstr("u, nm"));
  EXPECT_THAT(page.out, HasSubstr("k = 2"));
}

}  // namespace
}  // namespace driftwise::tests
