// Residuals of a model on runs that it was fitted to, and on others.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "server/application/motion/datum_opening.h"
#include "server/core/data/row_marks.h"
#include "server/formats/csv/dataset_csv.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Three runs half an hour apart in a room that warms: every zero is 340 nm from the one before.
class ModelResidualsTest : public testing::Test {
 protected:
  ModelResidualsTest() : cell(world, small_cell(folder / "cell.sqlite"), kSqlite) {
    world.warming_k_per_h = 4;
    for (int k = 0; k < 3; ++k) {
      runs.push_back(cell.begin_run(lines_of(6, {-4, -2, 1, 3, 4}, true)).id);
      cell.finish_run();
      cell.pass(1800);
    }
  }
  ModelId fitted_to(std::vector<RunId> wanted, const std::string& formula = "q1 ~ x + t01") {
    application::FitRequest fit;
    fit.runs = std::move(wanted);
    fit.formula = formula;
    const auto model = cell.await(cell->models.fit(cell.ada, fit));
    if (!model) throw std::runtime_error(model.error().message);
    return model->id;
  }
  application::ModelResiduals residuals(ModelId model, std::vector<RunId> wanted) {
    auto found = cell.await(cell->models.residuals(model, std::move(wanted), ""));
    if (!found) throw std::runtime_error(found.error().message);
    return std::move(*found);
  }
  static double mean(const std::vector<double>& values) {
    double sum = 0, count = 0;
    for (const double value : values)
      if (std::isfinite(value)) sum += value, ++count;
    return sum / count;
  }
  // Of one run among several, in order.
  static std::vector<double> of_run(const application::ModelResiduals& all, RunId run) {
    std::vector<double> values;
    for (std::size_t row = 0; row < all.data.rows; ++row)
      if (all.data.run[row] == run.value) values.push_back(all.outputs[0].values[row]);
    return values;
  }

  Folder folder;
  SmallWorld world;
  CellInMemory cell;
  std::vector<RunId> runs;
};

TEST_F(ModelResidualsTest, OfALaterRunAreItsErrorsOnTheCheckStandard) {
  const auto model = fitted_to({runs[0]});
  for (const RunId run : {runs[1], runs[2]}) {
    const auto found = residuals(model, {run});
    const auto check = cell.await(cell->checks.check_model(model, {run}));
    ASSERT_TRUE(check);
    EXPECT_NEAR(mean(found.outputs[0].values), check->report.outputs[0].points[0].bias, 1e-6);
    EXPECT_LT(std::abs(mean(found.outputs[0].values)), 40) << "the zeros' distance is no error";
    EXPECT_THAT(found.mean_taken_out, IsEmpty());
    EXPECT_FALSE(found.same_rows);
  }
}

TEST_F(ModelResidualsTest, OfOneOfItsRunsAreThoseThatTheRunHasAmongAll) {
  const auto model = fitted_to({runs[0], runs[1]});
  const auto all = residuals(model, {});
  EXPECT_TRUE(all.same_rows);
  EXPECT_EQ(residuals(model, {runs[1]}).outputs[0].values, of_run(all, runs[1]));
  EXPECT_EQ(residuals(model, {runs[1], runs[0]}).outputs[0].values, all.outputs[0].values);
}

TEST_F(ModelResidualsTest, OfItsOwnAndALaterRunTogetherAreThoseOfEach) {
  const auto model = fitted_to({runs[0], runs[1]});
  const auto both = residuals(model, {runs[1], runs[2]});
  EXPECT_EQ(of_run(both, runs[1]), residuals(model, {runs[1]}).outputs[0].values);
  EXPECT_EQ(of_run(both, runs[2]), residuals(model, {runs[2]}).outputs[0].values);
  EXPECT_LT(std::abs(mean(of_run(both, runs[2]))), 40);
}

TEST_F(ModelResidualsTest, OfAModelInOtherUnitsAreThoseOfTheSameModelInTheCells) {
  const auto csv = cell.await(cell->datasets.export_csv({runs[0]}, false));
  ASSERT_TRUE(csv);
  auto data = formats::read_dataset_csv(*csv, "run.csv");
  ASSERT_TRUE(data);
  application::FitRequest fit;
  fit.formula = "q1 ~ x + t01";
  fit.csv = formats::write_dataset_csv(*data);
  const auto own = cell.await(cell->models.fit(cell.ada, fit));
  for (auto& column : data->columns) {
    const std::string unit = column.channel.unit;
    if (unit == "degC") column.channel.unit = "K";
    if (unit == "mm") column.channel.unit = "um";
    for (double& value : column.values)
      value = unit == "degC" ? value + 273.15 : unit == "mm" ? value * 1e3 : value;
  }
  fit.csv = formats::write_dataset_csv(*data);
  const auto foreign = cell.await(cell->models.fit(cell.ada, fit));
  ASSERT_TRUE(own && foreign) << (own ? foreign : own).error().message;
  const auto expected = residuals(own->id, {runs[1]}).outputs[0].values;
  const auto found = residuals(foreign->id, {runs[1]}).outputs[0].values;
  const auto of_text = cell.await(cell->models.residuals(foreign->id, {}, *csv));
  const auto of_own = cell.await(cell->models.residuals(own->id, {}, *csv));
  ASSERT_TRUE(of_text && of_own);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t row = 0; row < expected.size(); ++row)
    EXPECT_NEAR(found[row], expected[row], 0.01);
  for (std::size_t row = 0; row < of_own->data.rows; ++row)
    EXPECT_NEAR(of_text->outputs[0].values[row], of_own->outputs[0].values[row], 0.01);
}

TEST_F(ModelResidualsTest, OfARunWithoutAKnownZeroHaveNoMeanAndSaySo) {
  const auto model = fitted_to({runs[0]});
  const auto csv = cell.await(cell->datasets.export_csv({runs[2]}, false));
  ASSERT_TRUE(csv);
  const auto imported = cell.await(cell->datasets.import_csv(cell.ada, "copy", *csv, ""));
  ASSERT_TRUE(imported) << imported.error().message;
  const auto found = residuals(model, {imported->id});
  EXPECT_NEAR(mean(found.outputs[0].values), 0, 1e-6);
  EXPECT_THAT(found.mean_taken_out, ElementsAre(imported->id));
}

// A plan without returns of its own: the axis returns after each line by itself, and the row of the
// plan is no longer the place in the dataset.
TEST_F(ModelResidualsTest, NameTheRowOfThePlanThatIsKeptOutByThatNumber) {
  const RunId run = cell.begin_run(lines_of(6, {-4, -2, 1, 3, 4}, false)).id;
  cell.finish_run();
  const auto found = residuals(fitted_to({run}), {run});
  const auto points = cell.await(cell.points(run, 0, 1000, true));
  ASSERT_TRUE(points);
  ASSERT_EQ(found.origins.size(), found.data.rows);
  ASSERT_EQ(found.data.rows, 37u) << "30 points, the first zero and a return after each line";
  std::size_t largest = 0;
  for (std::size_t row = 0; row < found.data.rows; ++row) {
    EXPECT_EQ(found.origins[row].run, run);
    const auto point = std::ranges::find(*points, found.origins[row].row, &PointRecord::row);
    ASSERT_NE(point, points->end());
    EXPECT_EQ(point->passage, is_passage(found.data, row));
    if (point->passage) continue;
    EXPECT_EQ(found.data.find("x")->values[row], *application::find_value(point->values, "x_mm"));
    if (row > 12 && (largest == 0 || std::abs(found.outputs[0].values[row]) >
                                         std::abs(found.outputs[0].values[largest])))
      largest = row;
  }
  ASSERT_NE(found.origins[largest].row, static_cast<std::int64_t>(largest));
  ExclusionRecord wrong;
  wrong.run = run;
  wrong.rows = {found.origins[largest].row};
  wrong.reason = "wrong";
  ASSERT_TRUE(cell.await(cell->annotations.exclude_rows(cell.ada, wrong)));
  const auto after = residuals(fitted_to({run}), {run});
  EXPECT_EQ(after.data.excluded[largest], kExcludedRow);
  EXPECT_EQ(std::ranges::count(after.data.excluded, kExcludedRow), 1);
}

TEST_F(ModelResidualsTest, OfATextHaveNoRowsOfAPlan) {
  const auto model = fitted_to({runs[0]});
  const auto csv = cell.await(cell->datasets.export_csv({runs[0]}, false));
  ASSERT_TRUE(csv);
  const auto found = cell.await(cell->models.residuals(model, {}, *csv));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(found->origins, IsEmpty());
}

}  // namespace
}  // namespace driftwise::tests
