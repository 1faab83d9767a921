// A cell file that changes under a run and under a model: recorded, asked about, named.

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "server/application/plumbing/crash_point.h"
#include "server/application/provenance/provenance.h"
#include "server/compensation/target.h"
#include "tests/support/cell_in_memory.h"
#include "tests/support/small_cell_file.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const std::string kTrajectory = lines_of(4, {-4, -2.5, -1, 1.5, 3, 4}, true);

class ConfigurationTest : public testing::Test {
 protected:
  // A daemon on this cell file; the one before ends first, an hour of cell time earlier.
  CellInMemory& start(const std::string& cell_file) {
    cell.reset();
    begin = begin + std::chrono::hours(1);
    cell = std::make_unique<CellInMemory>(world, cell_of(cell_file), kSqlite, begin);
    cell->pass(30);
    return *cell;
  }
  std::string exchanged() const {
    return replaced(
        replaced(replaced(text, "input = 101", "input = 0"), "input = 102", "input = 101"),
        "input = 0", "input = 102");
  }
  RunId measured() {
    const auto run = cell->status().run ? cell->status().run->run : cell->begin_run(kTrajectory);
    const auto ended = cell->finish_run();
    EXPECT_EQ(ended.state, RunState::done) << ended.reason;
    return run.id;
  }
  ModelId fitted(RunId run, const std::string& formula, const std::string& select = "all") {
    application::FitRequest fit;
    fit.runs = {run};
    fit.formula = formula;
    fit.select = select;
    const auto model = cell->await((*cell)->models.fit(cell->ada, fit));
    if (!model) throw std::runtime_error(model.error().message);
    return model->id;
  }
  application::ModelGround ground(ModelId id) {
    return *cell->await((*cell)->provenance.ground_of_model(id));
  }
  application::RunGround ground(RunId id) {
    return cell->await((*cell)->provenance.grounds_of_runs({id}))->front();
  }
  compensation::Target target() {
    compensation::TargetRequest request;
    request.set(compensation::Variable::x, 1.5);
    return compensation::compute_target(*(*cell)->targets.snapshots().read(), request);
  }
  Result<ConfigurationStart> accept() {
    return cell->await((*cell)->configurations.accept(
        cell->ada, (*cell)->overview.description().hash, "the plugs were changed"));
  }

  Folder folder;
  SmallWorld world;
  const std::string text = small_cell_text(folder / "cell.sqlite");
  CellTime begin = kWorldBegin;
  std::unique_ptr<CellInMemory> cell;
};

TEST_F(ConfigurationTest, EveryStartIsOnRecordWithTheDifference) {
  auto& first = start(text);
  EXPECT_THAT(first.events_named("configuration.in_force"), ElementsAre(HasSubstr("the first")));
  start(text);
  const auto port = replaced(text, "127.0.0.1:3", "127.0.0.1:33");
  start("# the port of the laser moved\n" + port);
  auto& fourth = start(exchanged());
  const auto starts =
      *fourth.await(fourth.read([](Store& store) { return store.configurations().starts(10); }));
  ASSERT_EQ(starts.size(), 4u);  // newest first
  EXPECT_TRUE(starts[3].before_hash.empty());
  EXPECT_EQ(starts[2].before_hash, starts[3].hash);
  EXPECT_THAT(formats::read_changes_json(starts[2].changes_json), IsEmpty());
  EXPECT_FALSE(starts[1].asks) << "a port is recorded, and nobody is asked";
  ASSERT_THAT(formats::read_changes_json(starts[1].changes_json), SizeIs(1));
  EXPECT_TRUE(starts[0].is_open());
  EXPECT_THAT(fourth.events_named("configuration.changed"),
              ElementsAre(HasSubstr("device laser-x: port 3 -> 33"),
                          HasSubstr("probe t01_degC: input 101 -> 102")));
  // Every one of them can be read again.
  const auto old = fourth.await(fourth->configurations.get(starts[1].hash, ""));
  ASSERT_TRUE(old) << old.error().message;
  EXPECT_EQ(old->text, "# the port of the laser moved\n" + port);
  EXPECT_THAT(old->changes, SizeIs(3));  // the port back, and the two inputs
  EXPECT_EQ(fourth.await(fourth->configurations.get("0", "")).error().reason,
            "NO_SUCH_CONFIGURATION");
}

TEST_F(ConfigurationTest, AChangedPartIsAskedAboutBeforeARunContinues) {
  start(text);
  const auto run = cell->begin_run(kTrajectory).id;
  cell->until([&] { return cell->status().run->run.accepted == 3; });
  auto& again = start(exchanged());
  ASSERT_TRUE(again.status().run);
  const int moves = world.moves, homes = world.homes;
  again.pass(1800);
  EXPECT_EQ(again.status().run->run.state, RunState::waiting);
  EXPECT_THAT(again.status().run->run.reason, HasSubstr("probe t01_degC: input 101 -> 102"));
  EXPECT_EQ(world.moves, moves) << "nothing moves until a person answers";
  EXPECT_EQ(world.homes, homes);
  EXPECT_EQ(again.status().run->run.accepted, 3);
  EXPECT_THAT(again.status().attention, testing::Contains(HasSubstr("the cell file has changed")));
  EXPECT_EQ(again.await(again->runs.resume(again.ada, run, {})).error().reason,
            "CONFIGURATION_CHANGED");
  EXPECT_EQ(again.await(again->configurations.accept(again.ada, "seen another", "")).error().reason,
            "OTHER_CONFIGURATION");
  const auto accepted = accept();
  ASSERT_TRUE(accepted) << accepted.error().message;
  EXPECT_EQ(accepted->accepted_by, "ada");
  EXPECT_EQ(measured(), run);
  EXPECT_EQ(accept().error().reason, "NO_QUESTION");
  const auto used = ground(run).configurations;
  ASSERT_EQ(used.size(), 2u) << "the run names both";
  EXPECT_NE(used[0].hash, used[1].hash);
  EXPECT_EQ(used[1].hash, again->overview.description().hash);
  EXPECT_THAT(again.events_named("configuration.accepted"),
              ElementsAre(HasSubstr("the plugs were changed")));
}

TEST_F(ConfigurationTest, ARunThatIsAcceptedWaitsForTheEndOfTheMovementByHand) {
  start(text);
  cell->begin_run(kTrajectory);
  cell->until([&] { return cell->status().run->run.accepted == 3; });
  auto& again = start(exchanged());
  std::optional<Result<void>> homed;
  again.begin(again->manual.home(again.ada, again.lease(), again.answer()), homed);
  again.pass(0.5);
  const int homes = world.homes;
  ASSERT_FALSE(homed);
  ASSERT_TRUE(accept());
  again.until([&] { return homed || world.homes > homes + 1; });
  ASSERT_TRUE(homed) << "the run drove the axes meanwhile";
  EXPECT_TRUE(*homed) << homed->error().message;
  EXPECT_EQ(world.homes, homes + 1);
  const auto ended = again.finish_run();
  EXPECT_EQ(ended.state, RunState::done) << ended.reason;
  EXPECT_EQ(world.homes, homes + 2) << "the run homes after it";
}

TEST_F(ConfigurationTest, APortOrACommentDoesNotKeepARunWaiting) {
  start(text);
  const auto run = cell->begin_run(kTrajectory).id;
  cell->until([&] { return cell->status().run->run.accepted == 3; });
  start("# moved\n" + replaced(text, "127.0.0.1:3", "127.0.0.1:33"));
  EXPECT_EQ(measured(), run);
  EXPECT_THAT(ground(run).configurations, SizeIs(2)) << "recorded all the same";
}

TEST_F(ConfigurationTest, TheFilePutBackAsksNothingMore) {
  start(text);
  const auto run = cell->begin_run(kTrajectory).id;
  cell->until([&] { return cell->status().run->run.accepted == 3; });
  start(exchanged());
  EXPECT_EQ(cell->status().run->run.state, RunState::waiting);
  start(exchanged());  // an open question outlives a restart
  EXPECT_EQ(cell->status().run->run.state, RunState::waiting);
  start(text);
  EXPECT_EQ(measured(), run);
  EXPECT_THAT(ground(run).configurations, SizeIs(1));
}

TEST_F(ConfigurationTest, TargetsOfAModelThatUsesTheChangedPartAreRefusedUntilSomebodyAnswers) {
  start(text);
  const auto run = measured();
  const auto uses_t01 = fitted(run, "q ~ x + t01");
  ASSERT_TRUE(cell->await((*cell)->promotions.promote(cell->ada, uses_t01, true)));
  EXPECT_EQ(target().refusal, compensation::Refusal::none);
  start(exchanged());
  EXPECT_EQ(cell->status().serving, uses_t01);
  ASSERT_EQ(target().refusal, compensation::Refusal::configuration_changed);
  const auto said = compensation::refusal_error(*(*cell)->targets.snapshots().read(), target());
  EXPECT_EQ(said.reason, "CONFIGURATION_CHANGED");
  EXPECT_THAT(said.message, HasSubstr("probe t01_degC: input 101 -> 102"));
  ASSERT_TRUE(accept());
  EXPECT_EQ(target().refusal, compensation::Refusal::none);
  EXPECT_EQ(target().flags & compensation::kConfigurationChanged, 0u);
}

TEST_F(ConfigurationTest, TargetsOfAnotherModelAreServedWithTheFlag) {
  start(text);
  const auto model = fitted(measured(), "q ~ x + t03");
  ASSERT_TRUE(cell->await((*cell)->promotions.promote(cell->ada, model, true)));
  start(exchanged());
  const auto served = target();
  EXPECT_EQ(served.refusal, compensation::Refusal::none);
  EXPECT_NE(served.flags & compensation::kConfigurationChanged, 0u);
  EXPECT_THAT(compensation::describe_flags(*(*cell)->targets.snapshots().read(), served),
              HasSubstr("CONFIGURATION_CHANGED"));
}

TEST_F(ConfigurationTest, AModelNamesTheCellFileItWasMeasuredUnder) {
  start(text);
  const auto model = fitted(measured(), "q ~ x + t01");
  const auto then = (*cell)->overview.description().hash;
  EXPECT_EQ(ground(model).configurations.front().hash, then);
  EXPECT_THAT(ground(model).changes_since, IsEmpty());
  auto& later = start(replaced(exchanged(), "u_scale_nm = 20", "u_scale_nm = 40"));
  ASSERT_TRUE(accept());
  const auto now = ground(model);
  ASSERT_THAT(now.configurations, SizeIs(1));
  EXPECT_EQ(now.configurations.front().hash, then);
  EXPECT_EQ(now.present_hash, later->overview.description().hash);
  ASSERT_TRUE(now.measured_under);
  EXPECT_EQ(now.measured_under->find_axis("q1_mm")->u_scale_nm, 20) << "as declared then";
  EXPECT_THAT(now.changes_since, SizeIs(3));
  // Promoted now it would be fed with another thermometer: a person has to say so.
  const auto refused = later.await(later->promotions.promote(later.ada, model));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "NEEDS_CONFIRMATION");
  EXPECT_THAT(refused.error().message, HasSubstr("probe t01_degC: input 101 -> 102"));
  EXPECT_FALSE(later.status().serving);
  EXPECT_TRUE(later.await(later->promotions.promote(later.ada, model, true)));
}

TEST_F(ConfigurationTest, AnInstrumentsThermometerInAServedModelIsAskedAbout) {
  start(text);
  const auto run = measured();
  const auto refused =
      cell->await((*cell)->promotions.promote(cell->ada, fitted(run, "q ~ x + t05")));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "NEEDS_CONFIRMATION");
  EXPECT_THAT(refused.error().message, HasSubstr("t05 is a thermometer of the instrument"));
  // The small world's thermometers go together: the selection takes one of the robot's.
  const auto robot = fitted(run, "q ~ x + R", "stepwise");
  EXPECT_THAT(ground(robot).promotion_questions,
              testing::Each(testing::Not(HasSubstr("is a thermometer of"))));
  EXPECT_TRUE(cell->await((*cell)->promotions.promote(cell->ada, robot, true)));
}

// Killed around the answer's commit: the question is open and the run waits, or it is answered, the
// run names the new cell file and goes on.
bool answered_when_killed_at(const std::string& point) {
  Folder folder;
  const auto text = small_cell_text(folder / "cell.sqlite");
  const auto changed = replaced(text, "u_scale_nm = 20", "u_scale_nm = 40");
  {
    SmallWorld world;
    CellInMemory cell(world, cell_of(text), kSqlite);
    cell.begin_run(lines_of(2, {2, -3}, true));
    cell.until([&] { return cell.status().run->run.accepted == 2; });
  }
  const pid_t child = ::fork();
  if (child == 0) {
    application::on_crash_point([&point](std::string_view name) {
      if (name == point) ::raise(SIGKILL);
    });
    SmallWorld world;
    CellInMemory cell(world, cell_of(changed), kSqlite, kWorldBegin + std::chrono::hours(1));
    cell.pass(10);
    static_cast<void>(
        cell.await(cell->configurations.accept(cell.ada, cell->overview.description().hash, "")));
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << point << " was not passed";
  SmallWorld world;
  world.referenced = true;  // the controller was not away
  CellInMemory cell(world, cell_of(changed), kSqlite, kWorldBegin + std::chrono::hours(2));
  cell.pass(10);
  const bool waits = cell.status().run->run.state == RunState::waiting;
  const auto used =
      cell.await(cell->provenance.grounds_of_runs({RunId{1}}))->front().configurations;
  EXPECT_EQ(used.size(), waits ? 1u : 2u) << "the answer and the run's cell file are one commit";
  if (!waits) {
    EXPECT_EQ(cell.finish_run().state, RunState::done);
  }
  return !waits;
}

TEST(ConfigurationCrash, TheAnswerIsThereWholeOrNotAtAll) {
  EXPECT_FALSE(answered_when_killed_at("before_configuration_commit"));
  EXPECT_TRUE(answered_when_killed_at("after_configuration_commit"));
}

}  // namespace
}  // namespace driftwise::tests
