// The loop that improves, on virtual time: an axis that bends, and a search that looks for it.

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "server/application/plumbing/crash_point.h"
#include "server/application/provenance/provenance.h"
#include "server/formats/model/model_json.h"
#include "tests/unit/application/diagnosis/improved_cell.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

TEST_F(ImprovementTest, MeasuresFindsExtendsAndMeasuresAgainUntilNothingIsLeft) {
  application::ImproveRequest request;
  request.promotes = true;
  const auto begun = begin(request);
  ASSERT_TRUE(begun) << begun.error().message;
  d.cell.until(
      [&] {
        return look(begun->id).turns.size() == 1 && look(begun->id).turns[0].model &&
               look(begun->id).turns[0].runs.size() == 2;
      },
      400'000);
  EXPECT_FALSE(d.cell.status().serving) << "before the fresh points have shown the gain";
  const auto record = finished(begun->id);
  EXPECT_EQ(record.state, JobState::done);
  EXPECT_EQ(record.reason, "nothing beyond noise is left");
  ASSERT_EQ(record.turns.size(), 2u);
  const auto& first = record.turns[0];
  EXPECT_EQ(first.runs.size(), 2u);  // the measurement, and the fresh points
  ASSERT_EQ(first.gains.size(), 1u);
  EXPECT_GT(first.gains[0].before.a90, 200);  // 30 nm/mm^2 over +-4 mm
  ASSERT_TRUE(first.gains[0].measured && first.gains[0].measured_before);
  EXPECT_GT(first.gains[0].measured_before->a90, 200);  // on the very same points
  EXPECT_LT(first.gains[0].measured->u90, 30);          // the axis holds to 8 nm
  EXPECT_LT(std::abs(first.gains[0].measured->mean), 30);
  EXPECT_GE(first.gains[0].measured->a90, 0.97 * first.gains[0].measured->u90);
  EXPECT_THAT(first.what, HasSubstr("geometry_order x"));
  // Minutes in a room whose temperature no term follows: that question is a person's.
  EXPECT_FALSE(d.cell.status().serving);
  EXPECT_THAT(first.what, HasSubstr("was not promoted"));
  EXPECT_THAT(first.what, HasSubstr("a thermometer of the robot"));
  EXPECT_EQ(formats::read_model_json(d.cell.await(d.cell->models.get(*first.model))->json)->formula,
            "q ~ x + x^2");
  EXPECT_TRUE(record.turns[1].diagnosis);
  EXPECT_TRUE(record.turns[1].runs.empty());
  EXPECT_EQ(d.cell.events_named("improvement.done").size(), 1u);
}

TEST_F(ImprovementTest, ProposesOnlyUnlessItWasToldToPromote) {
  const auto record = finished(begin()->id);
  EXPECT_EQ(record.state, JobState::done) << record.reason;
  EXPECT_TRUE(record.turns[0].model);
  EXPECT_FALSE(d.cell.status().serving);
}

TEST_F(ImprovementTest, StopsWhenTheBudgetDoesNotHoldAnotherMeasurement) {
  application::ImproveRequest request;
  request.budget_s =
      d.cell.await(d.cell->trajectories.check("trajectory", kLines))->estimated_s * 1.1;
  const auto record = finished(begin(request)->id);
  EXPECT_EQ(record.state, JobState::done);
  EXPECT_THAT(record.reason, HasSubstr("budget"));
  EXPECT_EQ(record.turns.size(), 1u);
  EXPECT_FALSE(record.turns[0].gains[0].measured);
  EXPECT_THAT(record.reason, HasSubstr("nothing of it was accepted"));
  EXPECT_FALSE(d.look(*record.turns[0].diagnosis).extension);
}

// An end between the extension and the verdict of the fresh points: nothing unproved is in force.
class EndedInFreshPoints : public ImprovementTest {
 protected:
  EndedInFreshPoints() {
    id = begin()->id;
    d.cell.until(
        [&] {
          const auto turns = look(id).turns;
          return !turns.empty() && turns[0].runs.size() == 2 && d.cell.status().run &&
                 d.cell.status().run->run.accepted > 3;
        },
        400'000);
    diagnosis = *look(id).turns[0].diagnosis;
    EXPECT_TRUE(is_in_force(d.cell));
  }
  bool is_in_force(CellInMemory& cell) {
    const auto id_of = diagnosis;
    const auto extension = cell.await(
        cell.read([id_of](Store& store) { return store.extensions().extension(id_of); }));
    return (*extension)->stands();
  }

  ImprovementId id;
  DiagnosisId diagnosis;
};

TEST_F(EndedInFreshPoints, ByACancelUndoesTheExtension) {
  const auto cancelled = d.cell.await(d.cell->improvements.cancel(d.cell.ada, id));
  ASSERT_TRUE(cancelled);
  EXPECT_EQ(cancelled->state, JobState::cancelled);
  EXPECT_THAT(cancelled->reason,
              HasSubstr("diagnosis 1 was undone: no fresh points show its gain"));
  EXPECT_FALSE(is_in_force(d.cell));
  d.cell.until([&] { return !d.cell.status().run; });
  d.cell.pass(60);
  EXPECT_EQ(d.cell.events_named("extension.undone").size(), 1u);
  EXPECT_THAT(look(id).turns[0].what, HasSubstr("diagnosis 1 was undone"));
}

TEST_F(EndedInFreshPoints, ByAnAbortOfTheRunUndoesTheExtension) {
  ASSERT_TRUE(d.cell.await(d.cell->runs.abort(d.cell.ada, look(id).turns[0].runs[1], "fire")));
  const auto record = finished(id);
  EXPECT_EQ(record.state, JobState::failed);
  EXPECT_THAT(record.reason, HasSubstr("fire; diagnosis 1 was undone"));
  EXPECT_FALSE(is_in_force(d.cell));
}

TEST_F(EndedInFreshPoints, ByAStopUndoesTheExtension) {
  ASSERT_TRUE(d.cell.await(d.cell->manual.stop_all(d.cell.ada)));
  const auto record = finished(id);
  EXPECT_THAT(record.reason, HasSubstr("its runs stay; diagnosis 1 was undone"));
  EXPECT_FALSE(is_in_force(d.cell));
}

TEST_F(EndedInFreshPoints, LeavesAModelThatAPersonHasPromotedMeanwhile) {
  ASSERT_TRUE(d.cell.await(
      d.cell->promotions.promote(d.cell.ada, *look(id).turns[0].model, true, "needed today")));
  const auto cancelled = d.cell.await(d.cell->improvements.cancel(d.cell.ada, id));
  ASSERT_TRUE(cancelled);
  EXPECT_THAT(cancelled->reason, HasSubstr("stays in force without proof, for its model serves"));
  EXPECT_TRUE(is_in_force(d.cell));
}

// A copy of the record as a kill leaves it on the disk.
TEST_F(EndedInFreshPoints, ByAKillUndoesTheExtensionAtTheNextStart) {
  Folder killed;
  for (const char* file : {"cell.sqlite", "cell.sqlite-wal"})
    std::filesystem::copy_file(d.folder / file, killed / file);
  SmallWorld world;
  CellInMemory cell(world, small_cell(killed / "cell.sqlite"), kSqlite,
                    d.cell.now() + std::chrono::hours(1));
  EXPECT_FALSE(is_in_force(cell));
  const auto record =
      cell.await(cell.read([this](Store& store) { return store.improvements().improvement(id); }));
  EXPECT_EQ(record->state, JobState::failed);
  EXPECT_THAT(record->reason, HasSubstr("its runs stay; diagnosis 1 was undone"));
  cell.pass(1);
  EXPECT_EQ(cell.events_named("improvement.failed").size(), 1u);
}

// The cancel comes while the first run is being stored: the loop has not heard of it yet.
TEST_F(ImprovementTest, ACancelWhileTheRunIsCreatedEndsThatRunToo) {
  std::optional<ImprovementId> id;
  bool cancelled = false;
  application::on_crash_point([&](std::string_view name) {
    if (name != "after_run_create_commit" || !id || std::exchange(cancelled, true)) return;
    EXPECT_TRUE(d.cell.await(d.cell->improvements.cancel(d.cell.ada, *id)));
  });
  id = begin()->id;
  d.cell.until([&] { return cancelled; });
  application::on_crash_point({});
  std::vector<RunRecord> runs;
  d.cell.until([&] {
    runs = *d.cell.await(d.cell.runs(10, 0));
    return !runs.empty() && is_over(runs[0].state);
  });
  EXPECT_EQ(look(*id).state, JobState::cancelled);
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].state, RunState::aborted);
  EXPECT_EQ(runs[0].accepted, 0);
}

TEST_F(ImprovementTest, APauseIsWaitedOut) {
  const auto id = begin()->id;
  d.cell.until([&] { return d.cell.status().run && d.cell.status().run->run.accepted > 3; });
  const auto run = d.cell.status().run->run.id;
  ASSERT_TRUE(d.cell.await(d.cell->runs.pause(d.cell.ada, run)));
  d.cell.pass(3600);
  EXPECT_EQ(look(id).state, JobState::running);
  ASSERT_TRUE(d.cell.resume());
  EXPECT_EQ(finished(id).state, JobState::done);
}

TEST_F(ImprovementTest, AnAbortedRunEndsItWithTheReasonAndStays) {
  const auto id = begin()->id;
  d.cell.until([&] { return d.cell.status().run && d.cell.status().run->run.accepted > 3; });
  const auto run = d.cell.status().run->run.id;
  ASSERT_TRUE(d.cell.await(d.cell->runs.abort(d.cell.ada, run, "fire alarm")));
  const auto record = finished(id);
  EXPECT_EQ(record.state, JobState::failed);
  EXPECT_THAT(record.reason, HasSubstr("fire alarm"));
  EXPECT_EQ(d.cell.await(d.cell->runs.get(run))->state, RunState::aborted);
}

TEST_F(ImprovementTest, CancellingIsAtOnceAndStopsTheRobot) {
  const auto id = begin()->id;
  d.cell.until([&] { return d.cell.status().run && d.cell.status().run->run.accepted > 3; });
  const auto run = d.cell.status().run->run.id;
  const auto cancelled = d.cell.await(d.cell->improvements.cancel(d.cell.ada, id));
  ASSERT_TRUE(cancelled);
  EXPECT_EQ(cancelled->state, JobState::cancelled);
  d.cell.until([&] { return !d.cell.status().run; });
  EXPECT_EQ(d.cell.await(d.cell->runs.get(run))->state, RunState::aborted);
  EXPECT_EQ(look(id).state, JobState::cancelled);
}

TEST_F(ImprovementTest, ALeaseThatIsGivenUpEndsItBeforeTheNextMeasurement) {
  const auto id = begin()->id;
  d.cell.until([&] { return d.cell.status().run && d.cell.status().run->run.accepted > 3; });
  ASSERT_TRUE(d.cell->manual.give_up_lease(d.cell.ada, d.cell.lease()));
  const auto record = finished(id);
  EXPECT_EQ(record.state, JobState::failed);
  EXPECT_THAT(record.reason, HasSubstr("lease"));
  EXPECT_FALSE(record.turns[0].runs.empty());
}

class SlowDiagnosisTest : public ImprovementTest {
 protected:
  SlowDiagnosisTest() : ImprovementTest(looks_for_a_bend, true) {}
};
TEST_F(SlowDiagnosisTest, KeepsTheLeaseForTheNextMeasurement) {
  const auto id = begin()->id;
  d.cell.until([&] { return !d.cell.events_named("diagnosis.started").empty(); });
  d.cell.pass(3 * 3600);  // a lease lasts an hour at most
  d.cell.until(
      [&] {
        d.let_diagnoses_run();
        return look(id).state != JobState::running;
      },
      400'000);
  EXPECT_EQ(look(id).state, JobState::done) << look(id).reason;
  EXPECT_EQ(look(id).turns[0].runs.size(), 2u) << "the fresh points were measured";
}

TEST_F(ImprovementTest, RefusesWhatARunWouldBeRefusedFor) {
  application::ImproveRequest request;
  request.trajectory_text = "q1_mm\n99\n";
  EXPECT_EQ(begin(request).error().reason, "SOFT_LIMIT");
  request = {};
  request.formula = "q ~";
  EXPECT_EQ(begin(request).error().reason, "BAD_FORMULA");
  request = {};
  request.formula = "q ~ x + nosuch";
  EXPECT_EQ(begin(request).error().reason, "UNKNOWN_CHANNEL");
  request = {};
  request.max_turns = 1000;
  EXPECT_EQ(begin(request).error().reason, "BAD_TURNS");
  request = {};
  request.budget_s = 10;
  EXPECT_EQ(begin(request).error().reason, "BAD_BUDGET");
  request = {};  // 2 lines of 7: 8 calibration rows for 2 terms
  request.trajectory_text = lines_of(2, {-4, -2.5, -1, 1.5, 3, 4}, true);
  const int moves = d.world.moves;
  const auto short_plan = begin(request);
  EXPECT_EQ(short_plan.error().reason, "TOO_FEW_ROWS");
  EXPECT_THAT(short_plan.error().message, HasSubstr("8 rows to learn from"));
  EXPECT_THAT(short_plan.error().message, HasSubstr("needs 12 rows"));
  EXPECT_EQ(d.world.moves, moves) << "it is said before the first move";
  ASSERT_TRUE(begin());
  EXPECT_FALSE(begin());  // one at a time
}

// A bend that does not last: on the fresh points the model before is the better one.
TEST_F(ImprovementTest, IsUndoneWhenTheFreshPointsDoNotShowIt) {
  application::ImproveRequest request;
  request.promotes = true;
  const auto id = begin(request)->id;
  d.cell.until([&] { return !look(id).turns.empty() && !look(id).turns[0].gains.empty(); },
               400'000);
  d.world.bend_nm_per_mm2 = 0;
  const auto record = finished(id);
  EXPECT_EQ(record.state, JobState::done);
  EXPECT_THAT(record.reason, HasSubstr("was undone"));
  EXPECT_FALSE(d.cell.status().serving);
  EXPECT_TRUE(d.cell.await(d.cell.promotions())->empty())
      << "it never served, not even for a while";
  ASSERT_TRUE(record.turns[0].gains[0].measured && record.turns[0].gains[0].measured_before);
  EXPECT_GT(record.turns[0].gains[0].measured->a90, record.turns[0].gains[0].measured_before->a90);
}

// A lag of an hour needs five hours of readings before a row; these runs take minutes.
class SlowLagTest : public ImprovementTest {
 protected:
  SlowLagTest()
      : ImprovementTest([](const Dataset&, const dx::DiagnoseOptions& options) {
          auto found = diagnosis_with(options.baseline.formula,
                                      {finding_of("thermal_lag", "t01", effects::AppliesTo::robot,
                                                  {"lag(t01, 3600 s)"}, {-1e-4})});
          return Result<dx::Diagnosis>(promising(std::move(found)));
        }) {}
};

TEST_F(SlowLagTest, IsUndoneBecauseTheFreshPointsCannotJudgeIt) {
  const auto record = finished(begin()->id);
  EXPECT_EQ(record.state, JobState::done);
  EXPECT_THAT(record.reason, HasSubstr("cannot judge the gain"));
  EXPECT_THAT(record.reason, HasSubstr("it was undone"));
  ASSERT_TRUE(record.turns[0].diagnosis);
  const auto view = d.look(*record.turns[0].diagnosis);
  ASSERT_TRUE(view.extension);
  EXPECT_FALSE(view.extension->stands());
}

// A search that blames the laser for the axis' own bend, which the baseline holds: the corrected
// lengths are straight, and the model from them is as good as the one before, not better.
class BlamedLaserTest : public ImprovementTest {
 protected:
  BlamedLaserTest()
      : ImprovementTest([](const Dataset&, const dx::DiagnoseOptions& options) {
          auto found = diagnosis_with(
              options.baseline.formula,
              {finding_of("cosine_error", "x", effects::AppliesTo::correction, {"x^2"}, {3e-5})});
          return Result<dx::Diagnosis>(promising(std::move(found)));
        }) {}
};
TEST_F(BlamedLaserTest, IsUndoneBecauseBothModelsExpectTheSameReadings) {
  application::ImproveRequest request;
  request.formula = "q ~ x + x^2";
  request.promotes = true;
  const auto record = finished(begin(request)->id);
  EXPECT_EQ(record.state, JobState::done) << record.reason;
  EXPECT_THAT(record.reason, HasSubstr("fresh points do not show the gain"));
  ASSERT_EQ(record.turns.size(), 1u);
  const auto& gain = record.turns[0].gains.at(0);
  ASSERT_TRUE(gain.measured && gain.measured_before);
  EXPECT_NEAR(gain.measured_before->a90, gain.measured->a90, 3);  // 480 nm are taken off at 4 mm
  EXPECT_FALSE(d.look(*record.turns[0].diagnosis).extension->stands());
}

// A search that also names a laser whose scale drifts by 126 ppm/h.
class ImpossibleLaserTest : public ImprovementTest {
 protected:
  ImpossibleLaserTest()
      : ImprovementTest([](const Dataset& data, const dx::DiagnoseOptions& options) {
          auto found = looks_for_a_bend(data, options);
          if (found)
            found->findings.push_back(finding_of(
                "instrument_drift", "x", effects::AppliesTo::correction, {"x:drift()"}, {-126e-6}));
          return found;
        }) {}
};
TEST_F(ImpossibleLaserTest, IsLeftOutAndTheRestIsAccepted) {
  const auto record = finished(begin()->id);
  EXPECT_EQ(record.state, JobState::done) << record.reason;
  EXPECT_THAT(record.turns[0].what, HasSubstr("not accepted: finding 2 (instrument_drift x)"));
  EXPECT_THAT(record.turns[0].what, HasSubstr("geometry_order x"));
  const auto corrections =
      d.cell.await(d.cell.read([](Store& store) { return store.extensions().corrections(); }));
  EXPECT_TRUE(corrections->empty());
  EXPECT_THAT(record.reason, HasSubstr("126 ppm/h")) << "the last turn has nothing else";
}

// A search that also names a cycle of a motor, which no target can follow.
class UnservableFindingTest : public ImprovementTest {
 protected:
  UnservableFindingTest()
      : ImprovementTest([](const Dataset& data, const dx::DiagnoseOptions& options) {
          auto found = looks_for_a_bend(data, options);
          if (found)
            found->findings.push_back(finding_of("cyclic_error", "q1", effects::AppliesTo::robot,
                                                 {"sin(q1, 93000 nm)"}, {1e-5}));
          return found;
        }) {}
};
TEST_F(UnservableFindingTest, IsLeftOutAndTheRestIsAccepted) {
  const auto record = finished(begin()->id);
  EXPECT_EQ(record.state, JobState::done) << record.reason;
  EXPECT_THAT(record.turns[0].what, HasSubstr("not accepted: finding 2 (cyclic_error q1)"));
  EXPECT_THAT(record.turns[0].what, HasSubstr("geometry_order x"));
  ASSERT_TRUE(record.turns[0].model);
  EXPECT_EQ(formats::read_model_json(d.cell.await(d.cell->models.get(*record.turns[0].model))->json)
                ->formula,
            "q ~ x + x^2");
  EXPECT_THAT(record.reason, HasSubstr("it cannot be served")) << "the last turn has nothing else";
}

// A search that also names a probe that sticks: no model, correction or row changes for it.
class StickingProbeTest : public ImprovementTest {
 protected:
  StickingProbeTest()
      : ImprovementTest([](const Dataset& data, const dx::DiagnoseOptions& options) {
          auto found = looks_for_a_bend(data, options);
          if (found)
            found->findings.push_back(
                finding_of("probe_hysteresis", "x", effects::AppliesTo::dataset, {}, {}));
          return found;
        }) {}
};
TEST_F(StickingProbeTest, IsLeftOutAndEndsTheTurnsWhereItIsAllThatWasFound) {
  const auto record = finished(begin()->id);
  EXPECT_EQ(record.state, JobState::done) << record.reason;
  EXPECT_THAT(record.turns[0].what, HasSubstr("geometry_order x"));
  EXPECT_THAT(record.reason, HasSubstr("changes no model, correction or row"));
}

}  // namespace
}  // namespace driftwise::tests
