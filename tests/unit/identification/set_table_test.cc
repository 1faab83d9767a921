// The table of models by sets of validation rows: its figures are those of fit() on the same rows.
#include "server/identification/set_table.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "server/formats/formula/formula.h"

namespace driftwise::identification {
namespace {

using testing::HasSubstr;

// One curved axis, every fourth row validation. The second datum was zeroed 0.05 mm from the first:
// its rows obey q = f(x + 0.05). A third datum has validation rows only.
struct CurveOfDatums {
  Dataset data;
  double motor(double x) const { return x + 0.02 * x * x; }
};

CurveOfDatums curve(bool third = false) {
  CurveOfDatums made;
  auto& data = made.data;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> place(-2, 2);
  DatasetColumn q{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}}, t{{"t07", "degC"}, {}};
  const int rows = third ? 220 : 200;
  for (int row = 0; row < rows; ++row) {
    const int datum = row / 100 + 1;
    const double zero = datum == 1 ? 0 : 0.05, x_mm = place(random),
                 degc = 20 + 0.5 * normal(random);
    data.time_s.push_back(10 * row);
    data.run.push_back(1);
    data.datum.push_back(datum);
    data.set.push_back(datum == 3 || row % 4 == 3 ? PointSet::validation : PointSet::calibration);
    x.values.push_back(x_mm);
    t.values.push_back(degc);
    q.values.push_back(made.motor(x_mm + zero) + 1e-3 * degc + 5e-6 * normal(random) +
                       (datum == 3 ? 0.7 : 0));
    ++data.rows;
  }
  data.columns = {q, x, t};
  return made;
}

std::vector<NamedFit> square(const Dataset& data) {
  std::vector<NamedFit> models(1);
  models[0].name = "G";
  models[0].fit.candidates = *formats::Formula::parse("q1 ~ x + x^2 + t07")->expand(data);
  return models;
}

TEST(SetTable, PredictsRowsOfAFurtherDatumInTheFirstOne) {
  const auto data = curve().data;
  const auto models = square(data);
  const auto model = calibration::fit(data, models[0].fit);
  ASSERT_TRUE(model) << model.error().message;
  const auto table = set_table(data, models, {{.name = "validation", .conditions = {}}});
  ASSERT_TRUE(table) << table.error().message;
  const double of_fit = *model->outputs[0].accuracy.a90_validation;
  EXPECT_LT(of_fit, 2 * 1.645 * 5e-6) << "the datum is moved";
  EXPECT_NEAR(table->cells[0].outputs[0].figures.a90, of_fit, 1e-9 * of_fit);
}

TEST(SetTable, LeavesOutRowsOfADatumThatWasNotCalibrated) {
  const auto data = curve(true).data;
  const auto table = set_table(data, square(data), {{.name = "validation", .conditions = {}}});
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->rows[0], 50);
  EXPECT_EQ(table->rows_unknown_datum, 20);
  EXPECT_LT(table->cells[0].outputs[0].figures.a90, 2 * 1.645 * 5e-6);
  const auto late = named_set_from("late: x -3..3");
  ASSERT_TRUE(late);
  auto only = data;
  for (std::size_t row = 0; row < 200; ++row) only.set[row] = PointSet::calibration;
  const auto none = set_table(only, square(only), {*late});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("their datum has no calibration rows"));
}

TEST(SetTable, CountsTheRowsThatTheFigureIsOf) {
  auto data = curve().data;
  data.columns[2].values[3] = data.columns[2].values[7] = kMissing;
  const auto models = square(data);
  const auto table = set_table(data, models, {{.name = "validation", .conditions = {}}});
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->rows[0], 50);
  EXPECT_EQ(table->cells[0].rows, 48);
  EXPECT_EQ(table->cells[0].outputs[0].figures.rows, 48);
}

}  // namespace
}  // namespace driftwise::identification
