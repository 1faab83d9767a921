// Serving plans from the command line, on a real cell: promoted, and taken back after a question.

#include <fmt/format.h>

#include "clients/cli/commands/indentation/indent_motors.h"
#include "driftwise/v1/plan_service.pb.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class PlanCommandsTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    std::string rows = "mn.q1_mm,mn.q2_mm,mn.q3_mm,mn.x_mm,mn.y_mm,mn.z_mm\n";
    for (int i = 0; i < 64; ++i) {
      const double a = i % 4 - 1.5, b = i / 4 % 4 - 1.5, c = i / 16 - 1.5;
      const double noise = 1e-6 * ((i * 7919) % 13 - 6);
      rows += fmt::format("{},{},{},{},{},{}\n", a + noise, b - noise, c + 2 * noise, a, b, c);
    }
    const auto imported = run({"data", "import", file("elsewhere.csv", rows)});
    ASSERT_EQ(imported.exit, 0) << imported.err;
    const auto fitted = run({"fit", "--run", "1", "--model", "mn.q ~ poly(mn.x, mn.y, mn.z, 1)"});
    ASSERT_EQ(fitted.exit, 0) << fitted.err;
    for (const char* name : {"first", "second"}) {
      const auto added =
          run({"plan", "add",
               file("plan.toml",
                    fmt::format("name = \"{}\"\n[[robot]]\nid = \"mn\"\nmodel = 1\n", name))});
      ASSERT_EQ(added.exit, 0) << added.err;
    }
  }
  void promote(const char* plan) {
    const auto promoted = run({"plan", "promote", plan, "--yes"});
    ASSERT_EQ(promoted.exit, 0) << promoted.err;
  }
  bool serves(std::size_t plan) {
    return json({"plan", "list"})["plans"][plan - 1]["serves"].get<bool>();
  }
};

TEST_F(PlanCommandsTest, ARollbackSaysWhatItPutsBackAndAsks) {
  promote("1");
  promote("2");
  const auto nobody = run({"plan", "rollback"});
  EXPECT_EQ(nobody.exit, 2) << "nobody is there to be asked";
  for (const char* fact : {"plan 2 serves no longer, for every controller",
                           "plan 1 'first' serves again: models 1\n", "--yes"})
    EXPECT_THAT(nobody.err, HasSubstr(fact));
  EXPECT_EQ(run({"plan", "rollback"}, true, "n\n").exit, 5);
  EXPECT_TRUE(serves(2)) << "nothing was changed";
  EXPECT_THAT(run({"plan", "rollback"}, true, "y\n").out, HasSubstr("plan 1 'first'"));
  EXPECT_TRUE(serves(1));
}

TEST_F(PlanCommandsTest, ARepeatedPromotionIsNoStepOfARollback) {
  promote("1");
  promote("2");
  const auto again = run({"plan", "promote", "2"});
  EXPECT_EQ(again.exit, 0) << again.err;
  EXPECT_EQ(again.out, "plan 2 serves already: nothing was changed\n");
  cell.on_store([](Store& store) {  // as earlier versions recorded it
    ASSERT_TRUE(
        store.plans().add_plan_promotion({PlanId{2}, kWorldBegin, "ada", "here", "promote"}));
  });
  EXPECT_THAT(run({"plan", "rollback"}).err, HasSubstr("plan 1 'first' serves again"));
  EXPECT_THAT(run({"plan", "rollback", "--yes"}).out, HasSubstr("plan 1 'first'"));
  EXPECT_TRUE(serves(1));
}

TEST_F(PlanCommandsTest, ARollbackOfTheFirstPlanSaysThatNoneServesThen) {
  promote("1");
  EXPECT_THAT(run({"plan", "rollback"}).err,
              HasSubstr("every joint target is refused (NO_PLAN) until one is promoted"));
  EXPECT_EQ(run({"plan", "rollback", "--yes"}).out, "no plan serves now\n");
  EXPECT_NE(run({"plan", "rollback"}).exit, 0) << "there is none to take back, nobody is asked";
}

// The record of a contact: which model really answered.
TEST(AnsweredBy, NamesTheCoarseModelWhereThatAnswered) {
  v1::JointTarget target;
  target.set_plan_id(1);
  auto& one = *target.add_robots();
  one.set_robot("mn");
  one.set_by(v1::RobotAnswer::BY_ONE);
  one.set_model_id(5);
  auto& two = *target.add_robots();
  two.set_robot("ma");
  two.set_model_id(2);
  two.set_coarse_model_id(1);
  two.set_by(v1::RobotAnswer::BY_FINE);
  EXPECT_EQ(cli::answered_by(target), "plan 1, mn=5, ma=fine:2");
  two.set_by(v1::RobotAnswer::BY_COARSE);
  EXPECT_EQ(cli::answered_by(target), "plan 1, mn=5, ma=coarse:1");
  two.set_by(v1::RobotAnswer::BY_BLEND);
  target.add_flags("OUTSIDE_DOMAIN(t19_degC)");
  EXPECT_EQ(cli::answered_by(target), "plan 1, mn=5, ma=blend:2+1 OUTSIDE_DOMAIN(t19_degC)");
}

}  // namespace
}  // namespace driftwise::tests
