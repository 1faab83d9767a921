#include "server/formats/export/model_c.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <sstream>
#include <utility>

#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/formats/text/text.h"
#include "server/plans/robot_parts.h"
#include "tests/unit/compensation/models.h"

namespace driftwise::formats {
namespace {

using compensation::axis_model;
using compensation::power;
using compensation::term;

// A folder of its own, gone with the test.
class CompiledModel : public testing::Test {
 protected:
  CompiledModel()
      : folder_(testing::TempDir() + "model_c_" + std::to_string(::getpid()) + "_" +
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::create_directories(folder_);
  }
  ~CompiledModel() override { std::filesystem::remove_all(folder_); }

  // The compiler's exit code; strict, so that a controller's own compiler has nothing to say
  // either.
  int compile(const std::string& source, const std::string& flags) {
    std::ofstream(folder_ + "/model.c") << source;
    return run("cc -std=c99 -pedantic -Wall -Wextra -Werror -O2 " + flags + " -o " + folder_ +
               "/model " + folder_ + "/model.c");
  }
  int run_model() { return run(folder_ + "/model > " + folder_ + "/out.txt"); }
  std::string output() {
    std::ifstream file(folder_ + "/out.txt");
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  static int run(const std::string& command) {
    const int status =
        std::system(command.c_str());  // NOLINT(cert-env33-c): the compiler is what is tested
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string folder_;
};

TEST_F(CompiledModel, PassesItsOwnVectorsToTheLastBit) {
  auto model = axis_model();
  model.outputs.push_back(model.outputs[0]);
  model.outputs[1].channel = {"q2", "mm"};
  model.outputs[1].terms[4] = term({power("y"), power("x", 3), power("force", 2)});
  model.domain.push_back({{"y", "mm"}, -1, 1});
  model.domain.push_back({{"force", "N"}, 0, 300});
  const auto source = write_model_c(model, "axis");
  ASSERT_TRUE(source) << source.error().message;
  ASSERT_EQ(compile(*source, "-DDRIFTWISE_MODEL_SELF_TEST"), 0);
  EXPECT_EQ(run_model(), 0) << output();
  EXPECT_EQ(output(), "0 of 48 values differ\n");
}

TEST_F(CompiledModel, CompilesWithoutTheSelfTestAndWithoutInputs) {
  calibration::Model constant = axis_model();
  auto& q1 = constant.outputs[0];
  q1.terms.resize(1);
  q1.coefficients.conservativeResize(1);
  constant.domain.clear();
  ASSERT_EQ(compile(*write_model_c(axis_model(), "axis"), "-c"), 0);
  ASSERT_EQ(compile(*write_model_c(constant, "constant"), "-c"), 0);
}

// A harness of our own around the exported function: values the vectors do not hold, and the domain
// bits.
TEST_F(CompiledModel, AgreesWithTheFormulaAndFlagsTheDomain) {
  std::string source = *write_model_c(axis_model(), "axis");
  source +=
      "#include <stdio.h>\nint main(void) {\n  const double pose[1] = {-3.7}, t[1] = {20.7}, "
      "far[1] = {9.0}, cold[1] = {-5.0};\n"
      "  double q[1];\n  int a = driftwise_model_axis(pose, t, q);\n  printf(\"%.17g %d\", q[0], "
      "a);\n"
      "  a = driftwise_model_axis(far, t, q);\n  printf(\" %d\", a);\n  a = "
      "driftwise_model_axis(far, cold, q);\n  printf(\" %d\\n\", a);\n  return 0;\n}\n";
  ASSERT_EQ(compile(source, ""), 0);
  ASSERT_EQ(run_model(), 0);
  double q = 0;
  int inside = -1, x_out = -1, both_out = -1;
  ASSERT_EQ(std::sscanf(output().c_str(), "%lf %d %d %d", &q, &inside, &x_out, &both_out), 4);
  const double x = -3.7, t = 20.7;
  EXPECT_DOUBLE_EQ(q, 1.0 + 2.0 * x + 0.5 * (x * x) + 1e-3 * t + 2e-4 * (x * t));
  EXPECT_EQ(inside, 0);
  EXPECT_EQ(x_out, 1);
  EXPECT_EQ(both_out, 3);
}

// The daemon folds the temperatures into the coefficients first, so its sum runs in another order:
// of n terms it differs by no more than n eps of their sizes, twice.
TEST_F(CompiledModel, DiffersFromTheDaemonsTargetByTheRoundingOfItsSumAlone) {
  const auto model = axis_model();
  std::string source = *write_model_c(model, "axis");
  EXPECT_EQ(source.find("daemon's digits"), std::string::npos);
  EXPECT_NE(source.find("differs from it by\n * rounding"), std::string::npos);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> along(-4, 4), warm(20, 22);
  std::vector<std::pair<double, double>> places;
  source += "#include <stdio.h>\nint main(void) {\n  double q[1];\n";
  for (int i = 0; i < 200; ++i) {
    const auto& [x, t] = places.emplace_back(along(random), warm(random));
    std::ostringstream call;
    call.precision(17);
    call << "  { const double pose[1] = {" << x << "}, t[1] = {" << t
         << "}; (void)driftwise_model_axis(pose, t, q); printf(\"%.17g \", q[0]); }\n";
    source += call.str();
  }
  ASSERT_EQ(compile(source + "  return 0;\n}\n", ""), 0);
  ASSERT_EQ(run_model(), 0);
  std::istringstream printed(output());
  auto builder = *compensation::SnapshotBuilder::create(model, ModelId{1}, CellDescription{});
  builder.keep_model_datum();
  for (const auto& [x, t] : places) {
    const ChannelValue t07{"t07_degC", t};
    builder.observe(std::span(&t07, 1), CellTime{1'000'000'000});
    compensation::TargetRequest request;
    request.set(compensation::Variable::x, x);
    const auto target =
        compensation::compute_target(builder.build(CellTime{1'000'000'000}), request);
    const double sizes = 1.0 + std::abs(2.0 * x) + 0.5 * x * x + 1e-3 * t + 2e-4 * std::abs(x * t);
    double q = 0;
    ASSERT_TRUE(printed >> q);
    EXPECT_NEAR(q, target.q_mm[0], 2 * 5 * 2.2e-16 * sizes) << x << " mm, " << t << " degC";
  }
}

// Half a percent of the range on each side of it is inside, for the daemon and for the controller:
// x of -4 .. 4 up to 4.04, t07 of 20 .. 22 up to 22.01.
TEST_F(CompiledModel, HasTheEdgeOfTheDomainWhereTheDaemonHasIt) {
  const auto model = axis_model();
  std::string source = *write_model_c(model, "axis");
  const std::vector<double> places = {-4.0401, -4.0399, -4, 4.00024, 4.03, 4.0399, 4.0401},
                            warmths = {19.9899, 19.9901, 22, 22.0099, 22.0101};
  source += "#include <stdio.h>\nint main(void) {\n  double q[1];\n";
  for (const double x : places)
    for (const double t : warmths) {
      std::ostringstream call;
      call.precision(17);
      call << "  { const double pose[1] = {" << x << "}, t[1] = {" << t
           << "}; printf(\"%d \", driftwise_model_axis(pose, t, q)); }\n";
      source += call.str();
    }
  ASSERT_EQ(compile(source + "  return 0;\n}\n", ""), 0);
  ASSERT_EQ(run_model(), 0);
  std::istringstream bits(output());
  auto builder = *compensation::SnapshotBuilder::create(model, ModelId{1}, CellDescription{});
  for (const double x : places)
    for (const double t : warmths) {
      const ChannelValue warm{"t07_degC", t};
      builder.observe(std::span(&warm, 1), CellTime{1'000'000'000});
      compensation::TargetRequest request;
      request.set(compensation::Variable::x, x);
      const auto target =
          compensation::compute_target(builder.build(CellTime{1'000'000'000}), request);
      unsigned outside = 99;
      bits >> outside;
      EXPECT_EQ(outside, target.outside) << x << " mm, " << t << " degC";
      EXPECT_EQ((outside & 1) != 0, std::abs(x) > 4.04) << x;
      EXPECT_EQ((outside & 2) != 0, std::abs(t - 21) > 1.01) << t;
    }
}

// The robot has warmed and its axes stand 20 and -30 um from where pose 0 was in the model's data:
// a constant per motor would be wrong by the curvature and by x:t07.
TEST_F(CompiledModel, GoesOnFromTheZeroOfAnotherDatumByItsPose) {
  auto model = axis_model();
  model.outputs.push_back(model.outputs[0]);
  model.outputs[1].channel = {"q2", "mm"};
  model.outputs[1].terms = {term({}), term({power("y")}), term({power("x")}),
                            term({power("x"), power("y")}), term({power("y"), power("t07")})};
  model.domain.push_back({{"y", "mm"}, -4, 4});
  const auto q1 = [](double x, double, double t) {
    return 1.0 + 2.0 * x + 0.5 * x * x + 1e-3 * t + 2e-4 * x * t;
  };
  const auto q2 = [](double x, double y, double t) {
    return 1.0 + 2.0 * y + 0.5 * x + 1e-3 * x * y + 2e-4 * y * t;
  };
  std::string source = *write_model_c(model, "axis");
  char harness[1024];
  std::snprintf(
      harness, sizeof harness,
      "#include <stdio.h>\nint main(void) {\n  const double none[2] = {0.0, 0.0}, pose[2] = "
      "{2.0, -1.5}, then[1] = {20.5}, now[1] = {21.5}, q_zero[2] = {%.17g, %.17g};\n"
      "  double zero[4], q[2];\n  int moved = driftwise_model_axis_zero(none, then, q_zero, "
      "zero);\n  int outside = driftwise_model_axis_from(zero, pose, now, q);\n"
      "  printf(\"%%.17g %%.17g %%.17g %%.17g %%d %%d\\n\", zero[0], zero[1], q[0], q[1], moved, "
      "outside);\n  return 0;\n}\n",
      q1(0.02, -0.03, 20.5), q2(0.02, -0.03, 20.5));
  ASSERT_EQ(compile(source + harness, ""), 0);
  ASSERT_EQ(run_model(), 0);
  double x = 0, y = 0, one = 0, two = 0;
  int moved = -1, outside = -1;
  ASSERT_EQ(
      std::sscanf(output().c_str(), "%lf %lf %lf %lf %d %d", &x, &y, &one, &two, &moved, &outside),
      6);
  EXPECT_NEAR(x, 0.02, 1e-10);
  EXPECT_NEAR(y, -0.03, 1e-10);
  EXPECT_NEAR(one, q1(2.02, -1.53, 21.5), 1e-9);
  EXPECT_NEAR(two, q2(2.02, -1.53, 21.5), 1e-9);
  EXPECT_EQ(moved, 1);
  EXPECT_EQ(outside, 0);
}

// The axis of a robot with an id: every name of the robot's own channels carries it.
calibration::Model of_robot_ma(calibration::Model model) {
  for (auto& output : model.outputs) {
    output.channel.symbol.insert(0, "ma.");
    for (auto& one : output.terms)
      for (auto& factor : one.factors)
        if (auto* named = std::get_if<effects::Power>(&factor); named && named->symbol == "x")
          named->symbol = "ma.x";
  }
  for (auto& range : model.domain)
    if (range.channel.symbol == "x") range.channel.symbol = "ma.x";
  return model;
}

// The daemon serves the robot's own part of the model from the same zero.
TEST_F(CompiledModel, OfARobotWithAnIdGoesOnFromAnotherZeroAsTheDaemonDoes) {
  const auto model = of_robot_ma(axis_model());
  const double q_zero = 1.0 + 2 * 0.02 + 0.5 * 0.02 * 0.02 + 1e-3 * 20.5 + 2e-4 * 0.02 * 20.5;
  const auto source = write_model_c(model, "ma");
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_NE(source->find(" * robot: ma\n"), std::string::npos);
  char harness[1024];
  std::snprintf(
      harness, sizeof harness,
      "#include <stdio.h>\nint main(void) {\n  const double none[1] = {0.0}, pose[1] = "
      "{2.0}, then[1] = {20.5}, now[1] = {21.5}, q_zero[1] = {%.17g};\n"
      "  double zero[2], q[1];\n  int moved = driftwise_model_ma_zero(none, then, q_zero, "
      "zero);\n  int outside = driftwise_model_ma_from(zero, pose, now, q);\n"
      "  printf(\"%%.17g %%d %%d\\n\", q[0], moved, outside);\n  return 0;\n}\n",
      q_zero);
  ASSERT_EQ(compile(*source + harness, ""), 0);
  ASSERT_EQ(run_model(), 0);
  double found = 0;
  int moved = -1, outside = -1;
  ASSERT_EQ(std::sscanf(output().c_str(), "%lf %d %d", &found, &moved, &outside), 3);

  auto builder = compensation::SnapshotBuilder::create(*plans::part_of_robot(model, "ma"),
                                                       ModelId{1}, compensation::axis_cell());
  ASSERT_TRUE(builder) << builder.error().message;
  constexpr CellTime kNow{1'300'000'000'000'000'000};
  const std::vector<ChannelValue> zero = {{"q1_mm", q_zero}, {"t07_degC", 20.5}},
                                  later = {{"t07_degC", 21.5}};
  ASSERT_TRUE(builder->anchor(zero));
  builder->observe(later, kNow);
  compensation::TargetRequest request;
  request.set(compensation::Variable::x, 2);
  EXPECT_NEAR(found, compute_target(builder->build(kNow), request).q_mm[0], 1e-9);
  EXPECT_EQ(moved, 1);
  EXPECT_EQ(outside, 0);
}

TEST(WriteModelC, RefusesAModelOfSeveralRobots) {
  auto model = of_robot_ma(axis_model());
  model.outputs.push_back(axis_model().outputs[0]);
  const auto source = write_model_c(model, "both");
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().reason, "NOT_EXPORTABLE");
}

TEST(WriteModelC, RefusesAFunctionThatEachLibraryRoundsItsOwnWay) {
  auto model = axis_model();
  model.outputs[0].terms.back() = {{effects::Call{"contact", {"x"}, {}}}};
  const auto source = write_model_c(model, "axis");
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().reason, "NOT_EXPORTABLE");
  EXPECT_EQ(source.error().message.find("memory"), std::string::npos) << source.error().message;
}

TEST_F(CompiledModel, SaysWhenAnotherZeroIsKnownByAConstantOnly) {
  auto model = axis_model();  // a scale that was homed elsewhere: 1 mm of a range of 8 mm
  std::string source = *write_model_c(model, "axis");
  source +=
      "#include <stdio.h>\nint main(void) {\n  const double none[1] = {0.0}, t[1] = {20.5}, "
      "q_zero[1] = {9.0};\n  double zero[2], q[1];\n  int moved = "
      "driftwise_model_axis_zero(none, t, q_zero, zero);\n  (void)driftwise_model_axis_from(zero, "
      "none, t, q);\n  printf(\"%.17g %d\\n\", q[0], moved);\n  return 0;\n}\n";
  ASSERT_EQ(compile(source, ""), 0);
  ASSERT_EQ(run_model(), 0);
  EXPECT_EQ(output(), "9 0\n");
}

// Figure 3.11 of the study: temperatures are folded in every few seconds, the loop has geometry
// only. The fast part must cost a loop microseconds; 20 leave room for a busy machine.
TEST_F(CompiledModel, AnswersInAFastPartWhatTheSlowPartFoldedIn) {
  auto model = axis_model();
  model.outputs.push_back(model.outputs[0]);
  model.outputs[1].channel = {"q2", "mm"};
  model.outputs[1].terms[4] = term({power("y"), power("x", 3), power("force", 2)});
  model.domain.push_back({{"y", "mm"}, -1, 1});
  model.domain.push_back({{"force", "N"}, 0, 300});
  std::string source = *write_model_c(model, "axis");
  source +=
      "#include <stdio.h>\n#include <time.h>\nint main(void) {\n"
      "  const double zero[5] = {0.02, -0.01, 0.0, 0.3, -0.4};\n"
      "  double folded[driftwise_model_axis_folded], q[2], one[2], worst = 0.0, sum = 0.0;\n"
      "  int bits = 0, expected = 0, i, k;\n  clock_t begin;\n"
      "  for (k = 0; k < 200; ++k) {\n"
      "    const double t[1] = {15.0 + 0.1 * k};\n"
      "    const double pose[3] = {-5.0 + 0.05 * k, 0.011 * (k - 100), 1.7 * k};\n"
      "    (void)driftwise_model_axis_fold(t, folded);\n"
      "    bits |= driftwise_model_axis_fast(folded, pose, q) ^ driftwise_model_axis(pose, t, "
      "one);\n    expected |= driftwise_model_axis(pose, t, one);\n"
      "    for (i = 0; i < 2; ++i) if ((q[i] - one[i]) * (q[i] - one[i]) > worst) worst = "
      "(q[i] - one[i]) * (q[i] - one[i]);\n"
      "    bits |= driftwise_model_axis_fast_from(zero, folded, pose, q) ^ "
      "driftwise_model_axis_from(zero, pose, t, one);\n"
      "    for (i = 0; i < 2; ++i) if ((q[i] - one[i]) * (q[i] - one[i]) > worst) worst = "
      "(q[i] - one[i]) * (q[i] - one[i]);\n"
      "  }\n  begin = clock();\n"
      "  for (k = 0; k < 100000; ++k) {\n"
      "    const double pose[3] = {1e-5 * k, -1e-6 * k, 1.0};\n"
      "    (void)driftwise_model_axis_fast(folded, pose, q);\n    sum += q[0] + q[1];\n  }\n"
      "  printf(\"%d %d %.17g %.17g %g\\n\", bits, expected, worst, 1e6 * (double)(clock() - "
      "begin) / CLOCKS_PER_SEC / 100000, sum);\n  return 0;\n}\n";
  ASSERT_EQ(compile(source, ""), 0);
  ASSERT_EQ(run_model(), 0);
  int bits = -1, expected = -1;
  double worst_mm2 = -1, us = -1;
  ASSERT_EQ(std::sscanf(output().c_str(), "%d %d %lf %lf", &bits, &expected, &worst_mm2, &us), 4);
  EXPECT_EQ(bits, 0) << "both say the same of the domain";
  EXPECT_NE(expected, 0) << "some of these poses and temperatures lie outside";
  EXPECT_LT(worst_mm2, 1e-18) << "rounding: less than 1e-3 nm at 300 N squared";
  EXPECT_LT(us, 20);
  std::cout << "fast part: " << us << " us per target\n";
}

TEST(WriteModelC, RefusesANameThatIsNoIdentifier) {
  for (const char* name : {"", "a b", "a;b", "ä"})
    EXPECT_EQ(write_model_c(axis_model(), name).error().reason, "BAD_NAME") << name;
}

TEST(WriteModelC, RefusesATermWithMemoryByName) {
  auto model = axis_model();
  model.outputs[0].terms[3] = {{effects::Call{"lag", {"t07"}, {{600, "s"}}}}};
  const auto source = write_model_c(model, "axis");
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().reason, "NOT_EXPORTABLE");
  EXPECT_NE(source.error().message.find("lag(t07, 600 s)"), std::string::npos)
      << source.error().message;
}

TEST_F(CompiledModel, IsNotBrokenByWhatStandsInItsComments) {
  auto model = axis_model();
  model.formula = "q1 ~ x */ int main(void) { return 7; } /*\\\nx";
  model.lineage.source = "a\nb */ #error no";
  EXPECT_EQ(compile(*write_model_c(model, "axis"), "-c"), 0);
}

}  // namespace
}  // namespace driftwise::formats
