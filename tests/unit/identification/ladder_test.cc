// The ladder of terms, the learning curve, what limits a model and the table by sets, on data whose
// answer is known: the terms they were made of, and the noise that was put in.
#include "server/identification/ladder.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "server/formats/formula/formula.h"
#include "server/identification/learning_curve.h"
#include "server/identification/limits.h"
#include "server/identification/set_table.h"

namespace driftwise::identification {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Made {
  bool cubic = true, warm = true, force = false;
  double noise_mm = 5e-6;
  int lines = 40;
  unsigned seed = 3;
};

// Lines of 15 places along x at random y; a thermometer that drifts; every fifth line validation.
Dataset made(const Made& what) {
  std::mt19937 random(what.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> place(-2, 2);
  Dataset data;
  DatasetColumn q{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}}, y{{"y", "mm"}, {}}, t{{"t04", "degC"}, {}},
      force{{"force", "N"}, {}};
  for (int line = 0; line < what.lines; ++line) {
    const double y_mm = place(random);
    const double newton = line % 3;
    for (int i = 0; i < 15; ++i) {
      const auto row = static_cast<double>(data.rows++);
      data.time_s.push_back(15 * row);
      data.line.push_back(line);
      data.set.push_back(line % 5 == 4 ? PointSet::validation : PointSet::calibration);
      const double x_mm = place(random), degc = 21 + std::sin(row / 70);
      double value = x_mm + 0.01 * y_mm;
      if (what.cubic) value += 1e-4 * x_mm * x_mm * x_mm;
      if (what.warm) value += 3e-4 * (degc - 21);
      if (what.force) value += 1e-4 * newton * x_mm;
      x.values.push_back(x_mm);
      y.values.push_back(y_mm);
      t.values.push_back(degc + 1e-4 * normal(random));
      force.values.push_back(newton);
      q.values.push_back(value + what.noise_mm * normal(random));
    }
  }
  data.columns = {q, x, y, t};
  if (what.force) data.columns.push_back(force);
  return data;
}

LadderOptions line_by_line(const Dataset& data) {
  LadderOptions options;
  options.fit.candidates.outputs = {data.columns.front().channel.symbol};
  options.together = "line";
  options.folds = 5;
  options.most_order = 4;
  return options;
}

TEST(Ladder, TakesTheTermsTheDataWereMadeOfAndStops) {
  const auto data = made({});
  const auto ladder = climb(data, line_by_line(data));
  ASSERT_TRUE(ladder) << ladder.error().message;
  EXPECT_THAT(ladder->formula(), HasSubstr("poly(x, y, 3)"));
  EXPECT_THAT(ladder->formula(), HasSubstr("t04"));
  EXPECT_THAT(ladder->formula(), Not(HasSubstr("poly(x, y, 4)")));
  // What is left is the noise that was put in, to the statistics of 480 rows: 1 / sqrt(2 n) = 3 %.
  EXPECT_NEAR(ladder->steps.back().a90_rms, 1.645 * 5e-6, 0.8e-6);
  EXPECT_THAT(ladder->stopped, HasSubstr("none of"));
}

// As a cell with several robots measures it; another robot stands elsewhere meanwhile.
TEST(Ladder, TakesThePositionOfTheRobotThatTheOutputsAreOf) {
  auto data = made({.warm = false});
  auto other = data.columns[1];
  for (auto& column : data.columns)
    if (column.channel.symbol != "t04") column.channel.symbol = "ma." + column.channel.symbol;
  other.channel.symbol = "mn.x";
  std::ranges::reverse(other.values);
  data.columns.push_back(other);
  const auto ladder = climb(data, line_by_line(data));
  ASSERT_TRUE(ladder) << ladder.error().message;
  EXPECT_EQ(ladder->formula(), "ma.q1 ~ poly(ma.x, ma.y, 3)");
  EXPECT_TRUE(formats::fit_formula(data, ladder->formula(), {}));
}

TEST(Ladder, TakesNoTemperatureThatDoesNothing) {
  const auto data = made({.cubic = false, .warm = false});
  const auto ladder = climb(data, line_by_line(data));
  ASSERT_TRUE(ladder) << ladder.error().message;
  EXPECT_EQ(ladder->formula(), "q1 ~ poly(x, y, 1)");
  EXPECT_EQ(ladder->steps.size(), 2u);
}

// Every length in m, a place of 0.1 mm: less than 1e-4 of a m, and a position all the same.
TEST(Ladder, TakesWhatVariesByANanometreWhateverTheUnit) {
  auto data = made({.noise_mm = 1e-9});
  for (auto& column : data.columns)
    if (column.channel.unit == "mm") {
      column.channel.unit = "m";
      for (double& value : column.values) value *= 1e-5;
    }
  DatasetColumn held{{"z", "m"}, std::vector<double>(data.rows, 0.25)};
  data.columns.push_back(held);
  const auto ladder = climb(data, line_by_line(data));
  ASSERT_TRUE(ladder) << ladder.error().message;
  EXPECT_THAT(ladder->formula(), HasSubstr("poly(x, y, 3)"));
  EXPECT_THAT(ladder->notes, testing::ElementsAre(HasSubstr("z: taken as constant")));
}

TEST(Ladder, FindsAProductOfForceAndPosition) {
  const auto data = made({.force = true});
  const auto ladder = climb(data, line_by_line(data));
  ASSERT_TRUE(ladder) << ladder.error().message;
  EXPECT_THAT(ladder->formula(), HasSubstr("(force):poly(x, y, 1)"));
  EXPECT_NEAR(ladder->steps.back().a90_rms, 1.645 * 5e-6, 0.8e-6);
}

TEST(Ladder, DoesNotAskTheValidationRows) {
  auto data = made({});
  const auto before = climb(data, line_by_line(data));
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.set_of(row) == PointSet::validation) data.columns[0].values[row] += 1;
  const auto after = climb(data, line_by_line(data));
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->formula(), after->formula());
  EXPECT_EQ(before->steps.back().a90_rms, after->steps.back().a90_rms);
  EXPECT_GT(*after->steps.back().outputs[0].a90_validation, 1);
}

TEST(Ladder, GivesAFormulaThatFitTakes) {
  const auto data = made({.force = true});
  const auto ladder = climb(data, line_by_line(data));
  ASSERT_TRUE(ladder);
  const auto model = formats::fit_formula(data, ladder->formula(), {});
  ASSERT_TRUE(model) << model.error().message;
  // 120 validation rows: 1 / sqrt(2 n) = 6.5 %, three times.
  EXPECT_NEAR(*model->outputs[0].accuracy.a90_validation, 1.645 * 5e-6, 1.6e-6);
}

TEST(Ladder, RefusesDataWithoutAnythingToPredict) {
  const auto data = made({});
  LadderOptions options;
  const auto nothing = climb(data, options);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().reason, "NO_OUTPUT");
  options = line_by_line(data);
  options.folds = 1000;
  const auto folds = climb(data, options);
  ASSERT_FALSE(folds);
  EXPECT_EQ(folds.error().reason, "NO_BLOCKS");
}

CurveOptions curve_of(const Dataset& data, const std::string& formula) {
  CurveOptions options;
  options.fit.candidates = *formats::Formula::parse(formula)->expand(data);
  options.together = "line";
  options.sizes = 5;
  options.draws = 3;
  return options;
}

TEST(LearningCurve, FallsToTheNoiseAndSaysHowManyPointsSuffice) {
  const auto data = made({.noise_mm = 20e-6});
  const auto curve = learning_curve(data, curve_of(data, "q1 ~ poly(x, y, 3) + t04"));
  ASSERT_TRUE(curve) << curve.error().message;
  const auto& first = curve->points.front();
  const auto& last = curve->points.back();
  ASSERT_TRUE(first.random && last.random && last.spread);
  EXPECT_GT(first.random->a90, 1.2 * last.random->a90);
  // sqrt(1 + terms / rows) of the noise: 11 terms of 580 rows add one percent.
  EXPECT_NEAR(last.spread->a90, 1.645 * 20e-6, 2e-6);
  EXPECT_LT(curve->enough, curve->rows);
  EXPECT_LT(curve->gain_of_doubling, 0.1);
  // Three sizes begin at twice the terms, where anything falls steeply: that is not the end.
  auto few = curve_of(data, "q1 ~ poly(x, y, 3) + t04");
  few.sizes = 3;
  EXPECT_LT(learning_curve(data, few)->gain_of_doubling, 0.1);
}

TEST(LearningCurve, SpreadRowsReachTheCornersFirst) {
  Dataset data;
  DatasetColumn x{{"x", "mm"}, {}};
  std::vector<std::size_t> rows;
  for (int i = 0; i <= 100; ++i) {
    x.values.push_back(i / 100.0);
    rows.push_back(data.rows++);
  }
  data.columns = {x};
  const auto order = spread_order(data, rows, {"x"}, rows.size());
  EXPECT_EQ(order[0], 50u);
  EXPECT_THAT((std::vector{order[1], order[2]}), testing::UnorderedElementsAre(0u, 100u));
  EXPECT_EQ(order.size(), rows.size());
}

// Kennard and Stone as they wrote it: every row against every chosen one.
std::vector<std::size_t> spread_by_hand(const std::vector<std::array<double, 3>>& places) {
  const auto square = [&](std::size_t a, const std::array<double, 3>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += (places[a][k] - b[k]) * (places[a][k] - b[k]);
    return sum;
  };
  std::array<double, 3> mean{};
  for (const auto& place : places)
    for (std::size_t k = 0; k < 3; ++k) mean[k] += place[k] / static_cast<double>(places.size());
  std::vector<std::size_t> left(places.size()), order;
  std::iota(left.begin(), left.end(), 0);
  const auto take = [&](auto distance, bool farthest) {
    auto best = left.begin();
    for (auto it = left.begin(); it != left.end(); ++it)
      if (farthest ? distance(*it) > distance(*best) : distance(*it) < distance(*best)) best = it;
    order.push_back(*best);
    left.erase(best);
  };
  take([&](std::size_t row) { return square(row, mean); }, false);
  while (!left.empty())
    take(
        [&](std::size_t row) {
          double nearest = INFINITY;
          for (const std::size_t chosen : order)
            nearest = std::min(nearest, square(row, places[chosen]));
          return nearest;
        },
        true);
  return order;
}

TEST(LearningCurve, SpreadRowsAreThoseOfTheDirectSearch) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> place(0, 1);
  std::vector<std::array<double, 3>> places;
  for (int i = 0; i < 200; ++i)  // a lattice whose places are visited again, and scattered ones
    places.push_back(i < 120 ? std::array{(i % 5) / 4.0, (i / 5 % 4) / 3.0, (i / 20 % 3) / 2.0}
                             : std::array{place(random), place(random), place(random)});
  Dataset data;
  data.rows = places.size();
  for (std::size_t k = 0; k < 3; ++k) {
    DatasetColumn column{{std::string(1, "xyz"[k]), "mm"}, {}};
    for (const auto& at : places) column.values.push_back(at[k]);
    data.columns.push_back(column);
  }
  std::vector<std::size_t> rows(places.size());
  std::iota(rows.begin(), rows.end(), 0);
  const auto expected = spread_by_hand(places);
  EXPECT_EQ(spread_order(data, rows, {"x", "y", "z"}, rows.size()), expected);
  EXPECT_THAT(spread_order(data, rows, {"x", "y", "z"}, 90),
              testing::ElementsAreArray(expected.begin(), expected.begin() + 90));
}

LimitFacts facts() {
  LimitFacts facts;
  facts.unit = "nm";
  facts.a90_calibration = 10;
  facts.a90_blocks = 11;
  return facts;
}

TEST(LimitedBy, NamesTheCauseThatTheFiguresShow) {
  auto noise = facts();
  noise.pure_error = 6;
  EXPECT_EQ(limited_by(noise).cause, "noise");
  auto lack = facts();
  lack.pure_error = 2;
  lack.lack_of_fit_p = 1e-6;
  EXPECT_EQ(limited_by(lack).cause, "lack_of_fit");
  auto drift = facts();
  drift.slow_share = 0.8;
  drift.slow_rows = 40;
  EXPECT_EQ(limited_by(drift).cause, "drift");
  auto warm = facts();
  warm.a90_validation = 40;
  warm.uncovered = {"t07 0.8 K above"};
  EXPECT_EQ(limited_by(warm).cause, "temperatures");
  EXPECT_THAT(limited_by(warm).words, HasSubstr("t07 0.8 K above"));
  auto rows = facts();
  rows.a90_blocks = 30;
  EXPECT_EQ(limited_by(rows).cause, "rows");
  EXPECT_EQ(limited_by(facts()).cause, "unknown");
}

// 1.645 x 5 nm are 56 % of the variance of 11 nm: a term can take away the rest at most.
TEST(LimitedBy, NamesRepeatsThatAreMostOfTheVarianceAlsoWhereALackOfFitIsSignificant) {
  auto both = facts();
  both.pure_error = 5;
  both.lack_of_fit_p = 1e-6;
  EXPECT_EQ(limited_by(both).cause, "noise");
  EXPECT_THAT(limited_by(both).words,
              HasSubstr("8.22 nm of an A90 of 11 nm, 56 % of its variance"));
  both.pure_error = 4;
  EXPECT_EQ(limited_by(both).cause, "lack_of_fit");
  EXPECT_THAT(limited_by(both).words, HasSubstr("36 % of its variance"));
}

TEST(LimitedBy, NeverNamesAPartThatIsLargerThanTheWhole) {
  auto far = facts();  // the visits of a pose differ by what the model reads
  far.pure_error = 20;
  far.lack_of_fit_p = 1e-6;
  EXPECT_EQ(limited_by(far).cause, "unknown");
}

// An error that all rows share is in no residual: its whole is what a target states.
TEST(TargetLimitedBy, ComparesAnInstrumentWithTheUncertaintyOfATarget) {
  const auto limit = target_limited_by({"nm", 17.2, "laser", 14.1});
  ASSERT_TRUE(limit);
  EXPECT_EQ(limit->cause, "instrument");
  EXPECT_THAT(limit->words, HasSubstr("14.1 nm of a stated 1.645 u of 17.2 nm, 67 %"));
  EXPECT_FALSE(target_limited_by({"nm", 21, "laser", 14.1}));
  EXPECT_FALSE(target_limited_by({"nm"}));
}

TEST(LimitedBy, SeesTemperaturesThatTheCalibrationDidNotCover) {
  auto data = made({});
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.set_of(row) == PointSet::validation) data.columns[3].values[row] += 3;
  const auto model = formats::fit_formula(data, "q1 ~ poly(x, y, 3) + t04", {});
  ASSERT_TRUE(model);
  const auto found = limit_facts(data, *model, model->outputs[0]);
  ASSERT_EQ(found.uncovered.size(), 1u);
  EXPECT_THAT(found.uncovered[0], HasSubstr("t04"));
  EXPECT_EQ(limited_by(found).cause, "temperatures");
}

TEST(SetTable, JudgesEachModelOnEachNamedSet) {
  const auto data = made({.force = true});
  std::vector<NamedFit> models(2);
  models[0].name = "G";
  models[0].fit.candidates = *formats::Formula::parse("q1 ~ poly(x, y, 3) + t04")->expand(data);
  models[1].name = "GF";
  models[1].fit.candidates =
      *formats::Formula::parse("q1 ~ poly(x, y, 3) + t04 + force:x")->expand(data);
  const auto light = named_set_from("light: force -0.5..0.5");
  const auto heavy = named_set_from("heavy: force 1.5..2.5, x 1..2");
  ASSERT_TRUE(light && heavy);
  const auto table = set_table(data, models, {*light, *heavy});
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->cells.size(), 4u);
  EXPECT_GT(table->rows[0], table->rows[1]);
  // Without the force the heavy corner errs by 1e-4 mm and more; with it by the noise.
  EXPECT_GT(table->cells[1].outputs[0].figures.a90, 1e-4);
  EXPECT_LT(table->cells[3].outputs[0].figures.a90, 1.645 * 8e-6);
}

TEST(SetTable, RefusesSetsThatSayNothing) {
  EXPECT_EQ(named_set_from("inside: force").error().reason, "BAD_SET");
  EXPECT_EQ(named_set_from("inside: force 2..1").error().reason, "BAD_SET");
  EXPECT_EQ(named_set_from(": force 1..2").error().reason, "BAD_SET");
  const auto data = made({});
  EXPECT_EQ(set_table(data, {}, {*named_set_from("a: force 1..2")}).error().reason,
            "UNKNOWN_CHANNEL");
  EXPECT_EQ(set_table(data, {}, {*named_set_from("a: x 100..200")}).error().reason, "NO_ROWS");
}

}  // namespace
}  // namespace driftwise::identification
