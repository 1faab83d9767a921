// Improvements whose findings act on the readings of their own runs only.

#include <gmock/gmock.h>

#include <filesystem>
#include <optional>
#include <utility>

#include "server/application/diagnoses/extension_plan.h"
#include "server/application/plumbing/crash_point.h"
#include "tests/unit/application/diagnosis/improved_cell.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

class ImprovedReadings : public ImprovementTest {
 protected:
  using ImprovementTest::ImprovementTest;
  bool is_in_force(CellInMemory& cell, DiagnosisId id) {
    return (*cell.await(cell.read([id](Store& store) { return store.extensions().extension(id); })))
        ->stands();
  }
  // With what was named still in force, and nothing that serves.
  ImprovementRecord ended_with_it_in_force() {
    application::ImproveRequest request;
    request.promotes = true;
    auto record = finished(begin(request)->id);
    EXPECT_EQ(record.state, JobState::done) << record.reason;
    EXPECT_EQ(record.reason, "nothing beyond noise is left");
    EXPECT_EQ(record.turns.size(), 2u);
    EXPECT_TRUE(is_in_force(d.cell, record.turns.at(0).diagnosis.value()));
    EXPECT_TRUE(d.cell.await(d.cell.promotions())->empty());
    return record;
  }
};

// A search that names, once, a thermometer that jumped: fresh runs hold nothing of the jump.
class JumpedSensorTest : public ImprovedReadings {
 protected:
  JumpedSensorTest()
      : ImprovedReadings([](const Dataset& data, const dx::DiagnoseOptions& options) {
          auto found = diagnosis_with(options.baseline.formula, {});
          if (data.find("t01") != nullptr)
            found = diagnosis_with(
                options.baseline.formula,
                {finding_of("sensor_fault", "t01", effects::AppliesTo::dataset, {}, {})});
          return Result<dx::Diagnosis>(promising(std::move(found)));
        }) {}
};
TEST_F(JumpedSensorTest, StaysLeftOutWithoutFreshPoints) {
  const auto record = ended_with_it_in_force();
  EXPECT_THAT(record.turns[0].what, HasSubstr("stays: it marks readings of these runs"));
  EXPECT_EQ(record.turns[0].runs.size(), 1u);
  EXPECT_TRUE(record.turns[1].runs.empty());
}

TEST_F(JumpedSensorTest, ACancelWhileItIsAcceptedLeavesNothingInForce) {
  std::optional<ImprovementId> id;
  bool cancelled = false;
  application::on_crash_point([&](std::string_view name) {
    if (name != "after_extension_commit" || !id || std::exchange(cancelled, true)) return;
    EXPECT_TRUE(d.cell.await(d.cell->improvements.cancel(d.cell.ada, *id)));
  });
  id = begin()->id;
  d.cell.until([&] { return cancelled; }, 400'000);
  application::on_crash_point({});
  d.cell.until([&] { return d.cell.events_named("extension.undone").size() == 1; });
  EXPECT_EQ(look(*id).state, JobState::cancelled);
  EXPECT_FALSE(is_in_force(d.cell, look(*id).turns.at(0).diagnosis.value()));
}

// A copy of the record as a kill leaves it on the disk, when the next turn has begun.
TEST_F(JumpedSensorTest, AKillInTheNextTurnLeavesItInForce) {
  const auto id = begin()->id;
  d.cell.until([&] { return look(id).turns.size() == 2; }, 400'000);
  ASSERT_EQ(look(id).state, JobState::running);
  const DiagnosisId diagnosis = look(id).turns.at(0).diagnosis.value();
  Folder killed;
  for (const char* file : {"cell.sqlite", "cell.sqlite-wal"})
    std::filesystem::copy_file(d.folder / file, killed / file);
  SmallWorld world;
  CellInMemory cell(world, small_cell(killed / "cell.sqlite"), kSqlite,
                    d.cell.now() + std::chrono::hours(1));
  EXPECT_TRUE(is_in_force(cell, diagnosis));
}

// A search that names, once, a slow wave of the laser in time: its correction holds for the run
// that it was found in.
class WaveInTimeTest : public ImprovedReadings {
 protected:
  explicit WaveInTimeTest(double size_mm = 1e-6)
      : ImprovedReadings(
            [size_mm, looks = 0](const Dataset&, const dx::DiagnoseOptions& options) mutable {
              auto found = diagnosis_with(options.baseline.formula, {});
              if (looks++ == 0)
                found = diagnosis_with(
                    options.baseline.formula,
                    {finding_of("periodic_disturbance", "x", effects::AppliesTo::correction,
                                {"sin_t(600 s)", "cos_t(600 s)"}, {size_mm, size_mm})});
              return Result<dx::Diagnosis>(promising(std::move(found)));
            }) {}
};
TEST_F(WaveInTimeTest, StaysWhereFreshPointsAreNoWorse) {
  const auto record = ended_with_it_in_force();
  EXPECT_EQ(record.turns[0].runs.size(), 2u) << "fresh points show that the model is no worse";
  EXPECT_THAT(record.turns[0].what, HasSubstr("fresh points are no worse"));
}

// The same with a wave of 20 um that is none: the model from such readings is worse.
class FalseWaveTest : public WaveInTimeTest {
 protected:
  FalseWaveTest() : WaveInTimeTest(2e-2) {}
};
TEST_F(FalseWaveTest, IsUndoneWhereFreshPointsAreWorse) {
  const auto record = finished(begin()->id);
  EXPECT_EQ(record.state, JobState::done) << record.reason;
  EXPECT_THAT(record.reason, HasSubstr("fresh points are worse with it"));
  EXPECT_FALSE(is_in_force(d.cell, *record.turns[0].diagnosis));
}

TEST(ReachOfAFinding, IsWhatItActsOn) {
  using application::Reach, application::reach_of, effects::AppliesTo;
  EXPECT_EQ(reach_of(finding_of("outliers", "", AppliesTo::dataset, {}, {})), Reach::marks);
  EXPECT_EQ(reach_of(finding_of("step_change", "", AppliesTo::dataset, {"step(60 s)"}, {1e-6})),
            Reach::own_runs);
  EXPECT_EQ(
      reach_of(finding_of("instrument_drift", "x", AppliesTo::correction, {"drift()"}, {1e-6})),
      Reach::own_runs);
  EXPECT_EQ(reach_of(finding_of("cosine_error", "x", AppliesTo::correction, {"x"}, {1e-6})),
            Reach::every_run);
  EXPECT_EQ(reach_of(finding_of("geometry_order", "x", AppliesTo::robot, {"x^2"}, {1e-4})),
            Reach::every_run);
}

}  // namespace
}  // namespace driftwise::tests
