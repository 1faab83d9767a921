// A run of several robots in wanted poses: the serving plan says what each of them moves to.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "server/application/models/models.h"
#include "server/application/plans/plans.h"
#include "server/application/ports/run_plan.h"
#include "tests/unit/application/sqlite.h"
#include "tests/unit/application/two_robots.h"

namespace driftwise::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CompensatedRobots : public testing::Test {
 protected:
  CompensatedRobots() { restart(); }
  void restart() {
    cell.reset();
    auto description = two_robot_cell(folder / "cell.sqlite");
    description.devices[2].become<LengthSettings>().channel.symbol = "ma.z";
    CellInMemory::Further further;
    further.begin = kWorldBegin + starts++ * std::chrono::hours(1);
    cell.emplace(two_robot_devices(ma, mn), std::move(description), kSqlite, std::move(further));
  }
  std::int64_t fitted(const std::string& csv, const std::string& formula) {
    application::FitRequest request;
    request.csv = csv;
    request.formula = formula;
    const auto model = cell->await((*cell)->models.fit(cell->ada, std::move(request)));
    if (!model) throw std::runtime_error(model.error().message);
    return model->id.value;
  }
  // mn's scale is 0.1 % short; ma moves sideways by 1 um per mm of its height.
  PlanId a_promoted_plan() {
    std::string of_mn = "mn.q1_mm,mn.x_mm\n", of_ma = "ma.q1_mm,ma.z_mm,ma.x_mm\n";
    for (int i = 0; i < 40; ++i) {
      const double at = 0.2 * i - 4, noise = 1e-6 * ((i * 7919) % 13 - 6);
      of_mn += fmt::format("{},{}\n", 1.001 * at + noise, at);
      of_ma += fmt::format("{},{},{}\n", at - noise, at, 1e-3 * at + noise);
    }
    const auto text = fmt::format(
        "name = \"joint\"\n[[robot]]\nid = \"mn\"\nmodel = {}\n[[robot]]\nid = \"ma\"\nmodel = {}\n"
        "[[parasitic]]\nmodel = {}\nfrom = \"ma\"\nto = \"mn\"\nadd = [\"x_mm\"]\n",
        fitted(of_mn, "mn.q1 ~ mn.x"), fitted(of_ma, "ma.q1 ~ ma.z"), fitted(of_ma, "ma.x ~ ma.z"));
    const auto plan = cell->await((*cell)->plans.add(cell->ada, text, "", ""));
    if (!plan) throw std::runtime_error(plan.error().message);
    const auto promoted = cell->await((*cell)->plans.promote(cell->ada, plan->id, true));
    if (!promoted) throw std::runtime_error(promoted.error().message);
    return plan->id;
  }
  application::CreateRun asked(const std::string& csv) {
    application::CreateRun request;
    request.trajectory_name = "plan.csv";
    request.trajectory_text = csv;
    request.compensate = true;
    return request;
  }
  // A check alone refuses the same.
  std::string refusal_of(application::CreateRun request) {
    auto trial = request;
    trial.validate_only = true;
    const auto checked = cell->try_run(std::move(trial));
    const auto run = cell->try_run(std::move(request));
    EXPECT_FALSE(run);
    EXPECT_EQ(ma.moves + mn.moves, 0) << "refused before motion";
    EXPECT_EQ(checked ? "" : checked.error().message, run ? "" : run.error().message);
    return run ? std::string() : run.error().reason + ": " + run.error().message;
  }
  std::vector<PointRecord> points(RunId run) { return *cell->await(cell->points(run, 0, 1000)); }

  const std::string rows =
      "mn.x_mm,ma.z_mm,set,line,zero\n0,0,calibration,1,1\n1,2,calibration,1,0\n"
      "-2,2,validation,1,0\n1.5,-3,validation,2,0\n0,0,calibration,2,1\n";
  Folder folder;
  SmallWorld ma, mn;
  int starts = 0;
  std::optional<CellInMemory> cell;
};

double value_at(const PointRecord& point, const std::string& channel) {
  for (const auto& value : point.values)
    if (value.channel == channel) return value.value;
  return kMissing;
}

TEST_F(CompensatedRobots, MoveToWhatThePlanMakesOfTheirPoses) {
  const auto plan = a_promoted_plan();
  const auto run = cell->try_run(asked(rows));
  ASSERT_TRUE(run) << run.error().message;
  ASSERT_EQ(cell->finish_run().state, RunState::done);
  const auto all = points(run->id);
  ASSERT_EQ(all.size(), 5u);
  // ma first, in the order of the controllers. ma at 2 mm carries the work-piece 2 um sideways, and
  // mn follows on its short scale.
  EXPECT_NEAR(all[1].commanded_mm[0], 2, 2e-5);
  EXPECT_NEAR(all[1].commanded_mm[1], 1.001 * (1 + 2e-3), 2e-5);
  EXPECT_NEAR(all[3].commanded_mm[1], 1.001 * (1.5 - 3e-3), 2e-5);
  // Each robot is judged by what it was asked for.
  EXPECT_NEAR(value_at(all[1], "mn.x_target_mm"), 1 + 2e-3, 2e-5);
  EXPECT_NEAR(value_at(all[1], "ma.z_target_mm"), 2, 1e-12);
  EXPECT_NEAR(value_at(all[1], "ma.z_mm"), 2, 2e-3);
  const auto made = application::compensation_of(*run);
  EXPECT_TRUE(made.compensated);
  EXPECT_EQ(made.plan, plan);
  EXPECT_EQ(made.model, std::nullopt);
}

TEST_F(CompensatedRobots, AreVerifiedInTheCoordinatesThatWereMeasured) {
  a_promoted_plan();
  const auto run = cell->try_run(asked(rows));
  ASSERT_TRUE(run) << run.error().message;
  ASSERT_EQ(cell->finish_run().state, RunState::done);
  const auto seen = cell->await((*cell)->checks.verify_runs({run->id}, {}));
  ASSERT_TRUE(seen) << seen.error().message;
  ASSERT_EQ(seen->runs[0].coordinates.size(), 1u);
  EXPECT_EQ(seen->runs[0].coordinates[0].channel.name(), "ma.z_mm");
}

TEST_F(CompensatedRobots, GoOnAfterARestart) {
  a_promoted_plan();
  const auto run = cell->try_run(asked(rows));
  ASSERT_TRUE(run) << run.error().message;
  cell->until([&] { return cell->status().run->run.accepted >= 2; });
  restart();
  EXPECT_EQ(cell->finish_run().state, RunState::done);
  const auto all = points(run->id);
  ASSERT_EQ(all.size(), 5u);
  EXPECT_NEAR(all[3].commanded_mm[1], 1.001 * (1.5 - 3e-3), 2e-5);
}

TEST_F(CompensatedRobots, NeedAPlan) {
  EXPECT_THAT(refusal_of(asked(rows)), AllOf(HasSubstr("NO_PLAN"), HasSubstr("plan promote")));
}

TEST_F(CompensatedRobots, AreRefusedBeforeMotionWithTheRowThatCannotBe) {
  a_promoted_plan();
  auto request = asked(rows);
  request.validate_only = true;
  const auto would_be = cell->try_run(request);
  ASSERT_TRUE(would_be) << would_be.error().message;
  EXPECT_EQ(would_be->rows, 5);
  request.validate_only = false;
  EXPECT_EQ(ma.moves + mn.moves, 0) << "a check moves nothing";
  request.compensate = false;
  EXPECT_THAT(refusal_of(request), AllOf(HasSubstr("NEEDS_COMPENSATION"), HasSubstr("mn.x_mm")));
  request = asked(rows);
  request.compensate_with = ModelId{1};
  EXPECT_THAT(refusal_of(request), AllOf(HasSubstr("model 1"), HasSubstr("serving plan")));
  EXPECT_THAT(refusal_of(asked("mn.x_mm,set\n1,calibration\n")),
              AllOf(HasSubstr("MISSING_COORDINATE"), HasSubstr("robot 'ma'")));
  EXPECT_THAT(refusal_of(asked("mn.y_mm,ma.z_mm,set\n1,0,calibration\n")),
              AllOf(HasSubstr("row 1"), HasSubstr("mn.x_mm")));
  EXPECT_THAT(refusal_of(asked("mn.x_mm,ma.z_mm,set\n0,0,calibration\n2,2.5,calibration\n")),
              AllOf(HasSubstr("KEEP_OUT: plan.csv: row 2: robots ma and mn"), HasSubstr("'tips'")));
  EXPECT_THAT(refusal_of(asked("mn.x_mm,ma.z_mm,set\n-4.999,0,calibration\n")),
              AllOf(HasSubstr("SOFT_LIMIT"), HasSubstr("row 1"), HasSubstr("mn.q1_mm")));
}

}  // namespace
}  // namespace driftwise::tests
