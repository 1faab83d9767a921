#include "server/calibration/report/residual_statistics.h"

#include <gmock/gmock.h>

#include <random>

#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"
#include "tests/unit/calibration/data_files.h"

namespace driftwise::calibration {
namespace {

TEST(ResidualStatistics, AutocorrelationOfAnAlternatingSeriesIsMinusOne) {
  Eigen::VectorXd series(1000);
  for (Eigen::Index i = 0; i < 1000; ++i) series[i] = i % 2 == 0 ? 1 : -1;
  EXPECT_NEAR(lag1_autocorrelation(series), -1, 2e-3);
}

TEST(ResidualStatistics, EffectiveRowsFollowTheAutoregression) {
  EXPECT_DOUBLE_EQ(effective_rows(1000, 0), 1000);
  EXPECT_DOUBLE_EQ(effective_rows(1000, 0.5), 1000.0 / 3);
  EXPECT_NEAR(effective_rows(1000, 0.98), 10.1, 0.01);  // NUMERICS: about 10 of 1000 at 0.98
  EXPECT_DOUBLE_EQ(effective_rows(1000, -0.5), 1000);
}

// Worked by hand: at x = 1: 2, 4; x = 2: 5; x = 3: 7, 9, 8. Pure error SS = 2 + 2 = 4 on 1 + 2 dof.
TEST(PureError, OfExactRepeatsIsTheClassicalOne) {
  const Dataset data =
      columns_of({{{"y", "1"}, {2, 4, 5, 7, 9, 8}}, {{"x", "1"}, {1, 1, 2, 3, 3, 3}}});
  FitOptions options;
  options.select = Select::all;
  const auto model = formats::fit_formula(data, "y ~ x", options);
  ASSERT_TRUE(model.has_value());
  const auto& accuracy = model->outputs[0].accuracy;
  EXPECT_NEAR(*accuracy.pure_error, std::sqrt(4.0 / 3), 1e-12);
  // RSS - 4 on 4 - 3 = 1 degree of freedom, against 4/3
  const double rss = accuracy.rmse * accuracy.rmse * model->outputs[0].dof;
  EXPECT_NEAR(*accuracy.lack_of_fit_f, (rss - 4) / (4.0 / 3), 1e-9);
  EXPECT_GT(*accuracy.lack_of_fit_p, 0.05);
}

TEST(PureError, AndLackOfFitAreThoseOfR) {
  // tests/data/lack_of_fit/make_lack_of_fit.R: anova(model, one mean per distinct setting)
  const auto rows = read_rows("lack_of_fit/golden.csv");
  FitOptions options;
  options.select = Select::all;
  options.blocks = 0;
  int sets = 0;
  for (std::size_t at = 0; at < rows.size(); ++sets) {
    const auto& head = rows[at++];
    std::vector<double> y, x, z;
    for (std::size_t end = at + std::stoul(head[1]); at < end; ++at) {
      y.push_back(std::stod(rows[at][0]));
      x.push_back(std::stod(rows[at][1]));
      z.push_back(std::stod(rows[at][2]));
    }
    const Dataset data = columns_of({{{"y", "1"}, y}, {{"x", "1"}, x}, {{"z", "1"}, z}});
    const auto model = formats::fit_formula(data, "y ~ poly(x, " + head[2] + ") + z", options);
    ASSERT_TRUE(model.has_value()) << model.error().message;
    const auto& accuracy = model->outputs[0].accuracy;
    SCOPED_TRACE(sets);
    EXPECT_NEAR(*accuracy.pure_error / std::stod(head[3]), 1, 1e-10);
    EXPECT_NEAR(*accuracy.lack_of_fit_f / std::stod(head[4]), 1, 1e-9);
    EXPECT_NEAR(*accuracy.lack_of_fit_p / std::stod(head[5]), 1, 1e-9);
  }
  EXPECT_EQ(sets, 12);
}

TEST(PureError, OfRepeatedPosesIsTheNoiseOfTheReadings) {
  const auto model = formats::fit_formula(make_campaign({.rows = 2000}), "q1 ~ x + x^2 + T", {});
  ASSERT_TRUE(model.has_value());
  EXPECT_NEAR(*model->outputs[0].accuracy.pure_error, 3e-6, 0.2e-6);
  EXPECT_FALSE(
      model->outputs[0].accuracy.lack_of_fit_f.has_value());  // temperatures never repeat exactly
}

TEST(PureError, IsAbsentWhereNoPoseIsVisitedTwice) {
  Dataset data = make_campaign({});
  for (std::size_t i = 0; i < data.rows; ++i)
    data.columns[1].values[i] = -4 + 8.0 * static_cast<double>(i) / 400;
  const auto model = formats::fit_formula(data, "q1 ~ x + T", {});
  EXPECT_FALSE(model->outputs[0].accuracy.pure_error.has_value());
}

}  // namespace
}  // namespace driftwise::calibration
