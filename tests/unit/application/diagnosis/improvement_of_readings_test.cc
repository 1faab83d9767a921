// What an improvement does with a finding that acts on the readings of its own runs only.

#include <gmock/gmock.h>

#include "tests/unit/application/diagnosis/improved_cell.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

// A search that names, once, a thermometer that jumped: fresh runs hold nothing of the jump.
class JumpedSensorTest : public ImprovementTest {
 protected:
  JumpedSensorTest()
      : ImprovementTest([](const Dataset& data, const dx::DiagnoseOptions& options) {
          auto found = diagnosis_with(options.baseline.formula, {});
          if (data.find("t01") != nullptr)
            found = diagnosis_with(
                options.baseline.formula,
                {finding_of("sensor_fault", "t01", effects::AppliesTo::dataset, {}, {})});
          return Result<dx::Diagnosis>(promising(std::move(found)));
        }) {}
};
TEST_F(JumpedSensorTest, StaysLeftOutWithoutFreshPoints) {
  application::ImproveRequest request;
  request.promotes = true;
  const auto record = finished(begin(request)->id);
  EXPECT_EQ(record.state, JobState::done) << record.reason;
  EXPECT_EQ(record.reason, "nothing beyond noise is left");
  ASSERT_EQ(record.turns.size(), 2u);
  EXPECT_THAT(record.turns[0].what, HasSubstr("stays: it marks readings of these runs"));
  EXPECT_EQ(record.turns[0].runs.size(), 1u);
  EXPECT_TRUE(record.turns[1].runs.empty());
  EXPECT_TRUE(d.look(*record.turns[0].diagnosis).extension->stands());
  EXPECT_TRUE(d.cell.await(d.cell.promotions())->empty());
}

// A search that names, once, a slow wave of the laser in time: its correction holds for the run
// that it was found in.
class WaveInTimeTest : public ImprovementTest {
 protected:
  explicit WaveInTimeTest(double size_mm = 1e-6)
      : ImprovementTest(
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
  application::ImproveRequest request;
  request.promotes = true;
  const auto record = finished(begin(request)->id);
  EXPECT_EQ(record.state, JobState::done) << record.reason;
  EXPECT_EQ(record.reason, "nothing beyond noise is left");
  ASSERT_EQ(record.turns.size(), 2u);
  EXPECT_EQ(record.turns[0].runs.size(), 2u) << "fresh points show that the model is no worse";
  EXPECT_THAT(record.turns[0].what, HasSubstr("fresh points are no worse"));
  EXPECT_TRUE(d.look(*record.turns[0].diagnosis).extension->stands());
  EXPECT_TRUE(d.cell.await(d.cell.promotions())->empty());
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
  EXPECT_FALSE(d.look(*record.turns[0].diagnosis).extension->stands());
}

}  // namespace
}  // namespace driftwise::tests
