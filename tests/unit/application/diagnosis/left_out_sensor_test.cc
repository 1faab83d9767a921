// A thermometer that is left out, and the formula that names it.

#include <gmock/gmock.h>

#include "server/application/diagnoses/extension_plan.h"
#include "tests/unit/application/diagnosis/diagnosed_cell.h"

namespace driftwise::tests {
namespace {

using application::ExtensionPlan;
using application::RunsData;
using effects::AppliesTo;
using testing::HasSubstr;

RunsData rows_with(const std::vector<std::string>& thermometers) {
  RunsData rows;
  rows.data.rows = 4;
  const auto add = [&rows](const std::string& symbol, const std::string& unit) {
    rows.data.columns.push_back({{symbol, unit}, {1, 2, 3, 4}});
  };
  add("q1", "mm");
  add("x", "mm");
  for (const auto& symbol : thermometers) add(symbol, "degC");
  for (int row = 0; row < 4; ++row) rows.origins.push_back({RunId{1}, row});
  return rows;
}

Result<ExtensionPlan> planned(const std::string& baseline,
                              const std::vector<std::string>& thermometers,
                              const std::string& extra_term = "x^2") {
  const auto found = diagnosis_with(
      baseline, {finding_of("geometry_order", "x", AppliesTo::robot, {extra_term}, {-1e-4}),
                 finding_of("sensor_fault", "t02", AppliesTo::dataset, {}, {})});
  return application::plan_extension(DiagnosisId{1}, found, {1, 2}, rows_with(thermometers));
}

TEST(LeftOutSensor, TakesItsTermsOutOfTheBaseline) {
  const auto named = planned("q ~ x + t02 + x:t02", {"t01", "t02"});
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_EQ(named->baseline, "q1 ~ x");
  EXPECT_EQ(named->formula, "q1 ~ x + x^2");
  const auto range = planned("q ~ x + t01..t03 - 1", {"t01", "t02", "t03"});
  ASSERT_TRUE(range) << range.error().message;
  EXPECT_EQ(range->baseline, "q ~ x + t01..t03 - 1") << "it does without one in the middle";
  const auto end_of_range = planned("q ~ x + t01..t02", {"t01", "t02"});
  ASSERT_TRUE(end_of_range);
  EXPECT_EQ(end_of_range->baseline, "q1 ~ x + t01");
}

TEST(LeftOutSensor, LeavesAGroupAsItIsWrittenWhileItHasOthers) {
  const auto group = planned("q ~ x + T", {"t01", "t02"});
  ASSERT_TRUE(group) << group.error().message;
  EXPECT_EQ(group->formula, "q ~ x + T + x^2");
  const auto alone = planned("q ~ x + T", {"t02"});
  ASSERT_TRUE(alone) << alone.error().message;
  EXPECT_EQ(alone->formula, "q1 ~ x + x^2");
}

TEST(LeftOutSensor, LeavesABaselineAloneThatDoesNotNameIt) {
  const auto plan = planned("q ~ x + t01", {"t01", "t02"});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->formula, "q ~ x + t01 + x^2");
}

TEST(LeftOutSensor, IsRefusedBesideAFindingThatReadsIt) {
  const auto plan = planned("q ~ x", {"t01", "t02"}, "rate(t02, 300 s)");
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().reason, "NOTHING_TO_MAKE");
  EXPECT_THAT(plan.error().message, HasSubstr("accept one of the two"));
}

TEST(LeftOutSensor, IsAcceptedAsItWasPreviewed) {
  DiagnosedCell d([](const Dataset&, const dx::DiagnoseOptions& options) {
    return Result<dx::Diagnosis>(
        diagnosis_with(options.baseline.formula,
                       {finding_of("geometry_order", "x", AppliesTo::robot, {"x^2"}, {-1e-4}),
                        finding_of("sensor_fault", "t01", AppliesTo::dataset, {}, {})}));
  });
  const auto run = d.cell.await(d.cell->datasets.import_csv(d.cell.ada, "c", imported_csv(), ""));
  ASSERT_TRUE(run);
  const auto view = d.diagnosed(run->id, "q ~ x + t01");
  const auto preview = d.cell.await(d.cell->extensions.preview({view.record.id, {1, 2}, false}));
  ASSERT_TRUE(preview) << preview.error().message;
  EXPECT_EQ(preview->formula, "q1 ~ x + x^2");
  const auto made =
      d.cell.await(d.cell->extensions.accept(d.cell.ada, {view.record.id, {1, 2}, false}));
  EXPECT_TRUE(made) << made.error().message;
}

}  // namespace
}  // namespace driftwise::tests
