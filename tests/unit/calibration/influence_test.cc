// A systematic error put into the data against what the influence says it does: the oracle is
// another fit.

#include "server/calibration/report/influence.h"

#include <gmock/gmock.h>

#include "server/calibration/design/predict.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"

namespace driftwise::calibration {
namespace {

Model fitted_all(const Dataset& data, const std::string& formula) {
  FitOptions options;
  options.select = Select::all;
  const auto model = formats::fit_formula(data, formula, options);
  EXPECT_TRUE(model.has_value()) << model.error().message;
  return *model;
}

DatasetColumn& column_of(Dataset& data, const std::string& symbol) {
  for (auto& column : data.columns)
    if (column.channel.symbol == symbol) return column;
  throw std::out_of_range(symbol);
}

const Influence& influence_of(const OutputModel& output, const std::string& channel,
                              const std::string& by) {
  for (const auto& influence : output.influences)
    if (influence.channel == channel && influence.by == by) return influence;
  throw std::out_of_range(channel + " by " + by);
}

std::string full_name(const Dataset& data, const std::string& symbol) {
  const auto* column = data.find(symbol);
  return column == nullptr ? symbol : column->channel.name();
}

struct Case {
  const char* name;
  const char *channel, *by;
  double size;  // small: the law of propagation is of first order
};
class SystematicError : public testing::TestWithParam<Case> {};

TEST_P(SystematicError, MovesTheServedModelByTheShiftOfItsInfluence) {
  const auto& c = GetParam();
  Dataset data = make_campaign({.rows = 900});
  data.columns.push_back({{"ry", "arcsec"}, {}});
  for (std::size_t i = 0; i < data.rows; ++i)
    data.columns.back().values.push_back(20 * std::sin(0.7 * static_cast<double>(i)) +
                                         8 * data.columns[1].values[i]);
  const std::string formula = "q1 ~ x + x^2 + x^3 + t01 + t02 + x:t01";
  const auto before = fitted_all(data, formula);
  Dataset wrong = data;
  auto& channel = column_of(wrong, c.channel);
  for (std::size_t i = 0; i < data.rows; ++i)
    channel.values[i] += c.size * (std::string(c.by) == "1" ? 1.0 : data.find(c.by)->values[i]);
  const auto after = fitted_all(wrong, formula);

  const auto columns = raw_columns(data, before.outputs[0].terms);
  ASSERT_TRUE(columns);
  const Eigen::VectorXd found =
      *columns * (before.outputs[0].coefficients - after.outputs[0].coefficients);
  const Eigen::VectorXd expected =
      *columns *
      influence_of(before.outputs[0], full_name(data, c.channel), full_name(data, c.by)).shift *
      c.size;
  EXPECT_LT((found - expected).norm(), 1e-3 * expected.norm());
}
INSTANTIATE_TEST_SUITE_P(Table, SystematicError,
                         testing::Values(Case{"Offset", "x", "1", 1e-5},
                                         Case{"Factor", "x", "x", 1e-6},
                                         Case{"LeverArm", "x", "ry", 1e-7},
                                         Case{"Thermometer", "t01", "1", 1e-4}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(Influence, OfAnOffsetIsAbsorbedByTheConstantOfALinearThermometer) {
  const auto model = fitted_all(make_campaign({}), "q1 ~ x + x^2 + t01 + t02");
  const auto& output = model.outputs[0];
  const auto& shift = influence_of(output, "t01_degC", "1").shift;
  EXPECT_NEAR(shift[0], output.coefficients[3], 1e-9 * std::abs(output.coefficients[3]));
  EXPECT_LT(shift.tail(4).cwiseAbs().maxCoeff(), 1e-9 * std::abs(shift[0]));
}

TEST(Influence, OfADriftIsWhatItDoesToAFit) {
  Dataset data = make_campaign({.rows = 756});
  const std::string formula = "q1 ~ x + t01 + t02";
  const auto before = fitted_all(data, formula);
  constexpr double kDrift_mm_per_h = 2e-6;
  for (std::size_t i = 0; i < data.rows; ++i)
    column_of(data, "x").values[i] += kDrift_mm_per_h * (data.time_s[i] - data.time_s[0]) / 3600;
  const auto after = fitted_all(data, formula);
  const Eigen::VectorXd found = before.outputs[0].coefficients - after.outputs[0].coefficients;
  const Eigen::VectorXd expected =
      influence_of(before.outputs[0], "x_mm", "h").shift * kDrift_mm_per_h;
  EXPECT_LT((found - expected).norm(), 1e-3 * expected.norm());
}

TEST(Influence, OfADriftWithTheRoomIsWhatItDoesToAFit) {
  Dataset data = make_campaign({.rows = 756});
  const std::string formula = "q1 ~ x + t01";  // t02 is the device's own
  const auto before = fitted_all(data, formula);
  constexpr double kDrift_mm_per_k = 50e-6;
  const auto& room = column_of(data, "t02").values;
  for (std::size_t i = 0; i < data.rows; ++i)
    column_of(data, "x").values[i] += kDrift_mm_per_k * (room[i] - room[0]);
  const auto after = fitted_all(data, formula);
  const Eigen::VectorXd found = before.outputs[0].coefficients - after.outputs[0].coefficients;
  const Eigen::VectorXd expected =
      influence_of(before.outputs[0], "x_mm", "t02_degC").shift * kDrift_mm_per_k;
  EXPECT_LT((found - expected).norm(), 1e-3 * expected.norm());
}

TEST(Influence, OfARobotOfSeveralIsThatOfTheRobotAlone) {
  Dataset data = make_campaign({.rows = 400});
  data.columns.push_back({{"ry", "arcsec"}, data.find("x")->values});
  const auto alone = fitted_all(data, "q1 ~ x + x^2 + t01").outputs[0];
  for (const char* symbol : {"q1", "x", "ry"})
    column_of(data, symbol).channel.symbol.insert(0, "ma.");
  const auto one = fitted_all(data, "ma.q1 ~ ma.x + ma.x^2 + t01").outputs[0];
  ASSERT_EQ(one.influences.size(), alone.influences.size());
  for (const char* by : {"ma.x_mm", "ma.ry_arcsec", "h", "t02_degC"})
    EXPECT_EQ(influence_of(one, "ma.x_mm", by).shift,
              influence_of(alone, "x_mm", by[0] == 'm' ? by + 3 : by).shift)
        << by;
}

TEST(Influence, DoesNotDependOnHowManyRowsAreLookedAt) {
  const Dataset data = make_campaign({.rows = 20000});
  const auto model = fitted_all(data, "q1 ~ x + x^2 + t01");
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < data.rows; ++i)
    if (data.set_of(i) == PointSet::calibration) all.push_back(i);
  const Excerpt rows(data, all, model.outputs[0], 1500);
  EXPECT_EQ(rows.size(), 1500);
  const auto columns = rows.columns(model.outputs[0].terms);
  ASSERT_TRUE(columns);
  const auto fewer =
      influences_of(rows, Projection(*columns, model.outputs[0].terms, {}), {}, model.outputs[0]);
  ASSERT_TRUE(fewer);
  const auto& a = influence_of(model.outputs[0], "x_mm", "x_mm").shift;
  OutputModel from_fewer;
  from_fewer.influences = *fewer;
  EXPECT_LT((influence_of(from_fewer, "x_mm", "x_mm").shift - a).norm(), 1e-3 * a.norm());
}

// Data with a tilt and a thermometer that no term reads, as the rows of a calibration have them.
Dataset tilted_campaign() {
  Dataset data = make_campaign({.rows = 450});
  data.columns.push_back({{"ry", "arcsec"}, {}});
  for (std::size_t i = 0; i < data.rows; ++i)
    data.columns.back().values.push_back(20 * std::sin(0.7 * static_cast<double>(i)) +
                                         8 * data.find("x")->values[i]);
  return data;
}

double largest_effect(const Dataset& data, const OutputModel& output, const Influence& influence) {
  return (*raw_columns(data, output.terms) * influence.shift).cwiseAbs().maxCoeff();
}

TEST(Influence, OfAChannelThatARowLacksIsThatOfTheOtherRows) {
  const std::string formula = "q1 ~ x + x^2 + t01";
  const Dataset complete = tilted_campaign();
  const auto whole = fitted_all(complete, formula).outputs[0];
  Dataset lacking = complete;
  column_of(lacking, "ry").values[150] = kMissing;
  column_of(lacking, "t03").values[150] = kMissing;
  column_of(lacking, "t03").values[0] = kMissing;  // the row from which a drift counts
  const auto model = fitted_all(lacking, formula);
  EXPECT_THAT(model.warnings,
              testing::Not(testing::Contains(testing::HasSubstr("without a reading"))));
  for (const char* by : {"ry_arcsec", "t03_degC"}) {
    const auto& expected = influence_of(whole, "x_mm", by);
    auto difference = influence_of(model.outputs[0], "x_mm", by);
    EXPECT_NEAR(difference.rms, expected.rms, 0.02 * expected.rms) << by;
    difference.shift -= expected.shift;
    EXPECT_LT(largest_effect(complete, whole, difference),
              0.02 * largest_effect(complete, whole, expected))
        << by;
  }
}

TEST(Influence, OfAChannelThatEveryFifthRowLacksStaysWithAWarning) {
  const std::string formula = "q1 ~ x + x^2 + t01";
  const Dataset complete = tilted_campaign();
  Dataset data = complete;
  const auto whole = fitted_all(data, formula).outputs[0];
  for (std::size_t i = 3; i < data.rows; i += 5) column_of(data, "ry").values[i] = kMissing;
  const auto model = fitted_all(data, formula);
  EXPECT_THAT(model.warnings, testing::Contains(testing::HasSubstr("ry_arcsec in 60 of 300")));
  const auto& expected = influence_of(whole, "x_mm", "ry_arcsec");
  auto difference = influence_of(model.outputs[0], "x_mm", "ry_arcsec");
  difference.shift -= expected.shift;
  EXPECT_LT(largest_effect(complete, whole, difference),
            0.1 * largest_effect(complete, whole, expected));
}

TEST(Influence, OfAChannelThatHardlyAnyRowHasIsLeftOutWithAWarning) {
  Dataset data = tilted_campaign();
  for (std::size_t i = 20; i < data.rows; ++i) column_of(data, "ry").values[i] = kMissing;
  const auto model = fitted_all(data, "q1 ~ x + x^2 + t01");
  EXPECT_THAT(model.warnings,
              testing::Contains(testing::AllOf(testing::HasSubstr("ry_arcsec in 286 of 300"),
                                               testing::HasSubstr("too few"))));
  EXPECT_THROW(influence_of(model.outputs[0], "x_mm", "ry_arcsec"), std::out_of_range);
}

// Rows of a second datum without a tilt: its constant is determined by no row that has one.
TEST(Influence, OfAChannelThatOneDatumLacksIsThatOfTheOther) {
  Dataset data = make_campaign({.rows = 450, .datums = 2});
  data.columns.push_back({{"ry", "arcsec"}, tilted_campaign().find("ry")->values});
  const auto whole = fitted_all(data, "q1 ~ x + x^2 + t01").outputs[0];
  for (std::size_t i = 225; i < data.rows; ++i) column_of(data, "ry").values[i] = kMissing;
  const auto lacking = fitted_all(data, "q1 ~ x + x^2 + t01").outputs[0];
  const auto at =
      std::ranges::find(whole.terms, effects::Term{{effects::Power{"x", 1}}}) - whole.terms.begin();
  const double expected = influence_of(whole, "x_mm", "ry_arcsec").shift[at];
  const auto& shift = influence_of(lacking, "x_mm", "ry_arcsec").shift;
  EXPECT_TRUE(shift.allFinite());
  EXPECT_NEAR(shift[at], expected, 0.1 * std::abs(expected));
}

// The reading at the zero against rows whose noise forgets it, keeps it, and keeps half of it.
TEST(Influence, OfTheZeroIsWhatTheNoiseOfTheRowsKeepsOfIt) {
  const Dataset data = make_campaign({.rows = 400});
  const auto model = fitted_all(data, "q1 ~ x + x^2 + t01");
  const auto& output = model.outputs[0];
  std::vector<std::size_t> all(data.rows);
  for (std::size_t i = 0; i < data.rows; ++i) all[i] = i;
  const Excerpt rows(data, all, output, data.rows);
  const auto columns = rows.columns(output.terms);
  ASSERT_TRUE(columns);
  const Projection projection(*columns, output.terms, {});
  const auto shift = [&](const NoiseSpectrum& noise, const char* by) {
    OutputModel out;
    out.influences = *influences_of(rows, projection, noise, output);
    return influence_of(out, "x_mm", by).shift;
  };
  constexpr double kForever = 1e9, kAtOnce = 1e-3;  // rows
  const Eigen::VectorXd whole = shift({}, "1");
  EXPECT_LT((shift({.white = 0, .slow = {{kForever, 4}}}, "zero") - whole).norm(),
            1e-5 * whole.norm());
  EXPECT_LT((shift({.white = 4, .slow = {{kForever, 4}}}, "zero") - whole / 2).norm(),
            1e-5 * whole.norm());
  EXPECT_LT(shift({.white = 0, .slow = {{kAtOnce, 4}}}, "zero").norm(), 1e-9 * whole.norm());
}

}  // namespace
}  // namespace driftwise::calibration
