// The fit's JSON against DESIGN.md section 4, and the page for people.

#include "server/formats/model/fit_json.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;

calibration::Model a_model() {
  return *fit_formula(calibration::make_campaign({}), "q1 ~ x + x^2 + T", {});
}

TEST(FitJson, HasTheKeysOfTheContract) {
  const auto json = fit_json(a_model());
  EXPECT_EQ(json["schema"], "driftwise.fit.v1");
  EXPECT_EQ(json["formula"], "q1 ~ x + x^2 + T");
  EXPECT_EQ(json["rows"]["calibration"], 267);
  EXPECT_EQ(json["rows"]["validation"], 133);
  EXPECT_EQ(json["rows"]["dropped"], 0);
  const auto& q1 = json["outputs"]["q1"];
  EXPECT_EQ(q1["unit"], "mm");
  EXPECT_NEAR(q1["rmse_nm"].get<double>(), 3, 0.5);
  EXPECT_NEAR(q1["u90_calibration_nm"].get<double>(), 1.645 * 3, 1);
  EXPECT_NEAR(q1["u90_validation_nm"].get<double>(), 1.645 * 3, 1);
  EXPECT_EQ(q1["terms"][0]["term"], "1");
  EXPECT_EQ(q1["terms"].size(), 7u);  // every offered term
  for (const auto* key : {"term", "in", "coefficient", "standard_error", "t", "p"})
    EXPECT_TRUE(q1["terms"][3].contains(key)) << key;
  EXPECT_EQ(q1["history"][1]["action"], "enter");
  EXPECT_EQ(q1["history"][1]["term"], "x");
  EXPECT_TRUE(json["warnings"].is_array());
  EXPECT_TRUE(json.contains("fit_us"));
}

// Every second validation row is "inside", the others have no name.
TEST(FitJson, HasTheFiguresOfEachNamedValidationSet) {
  const auto data = calibration::make_campaign({});
  calibration::FitOptions options;
  int validating = 0;
  for (std::size_t row = 0; row < data.rows; ++row)
    options.set_names.push_back(data.set_of(row) == PointSet::calibration ? "calibration"
                                : ++validating % 2 == 1                   ? "inside"
                                                                          : "validation");
  const auto model = *fit_formula(data, "q1 ~ x + x^2 + T", options);
  const auto json = fit_json(model);
  const auto& q1 = json["outputs"]["q1"];
  const auto &inside = q1["validation_sets"]["inside"],
             &other = q1["validation_sets"]["validation"];
  EXPECT_EQ(inside["rows"], 67);
  EXPECT_EQ(other["rows"], 66);
  // All rows together: the mean and the mean square of the two, weighted by their rows.
  EXPECT_NEAR((67 * inside["mean_nm"].get<double>() + 66 * other["mean_nm"].get<double>()) / 133,
              q1["mean_validation_nm"].get<double>(), 1e-9);
  EXPECT_NEAR(std::sqrt((67 * std::pow(inside["a90_nm"].get<double>(), 2) +
                         66 * std::pow(other["a90_nm"].get<double>(), 2)) /
                        133),
              q1["a90_validation_nm"].get<double>(), 1e-9);
  EXPECT_THAT(fit_table(model, {}), HasSubstr("of them inside, 67 rows: A90 "));
  EXPECT_FALSE(fit_json(a_model())["outputs"]["q1"].contains("validation_sets"))
      << "no set has a name";
}

TEST(FitJson, WritesNumbersThatReadBackExactly) {
  const auto model = a_model();
  const auto again = nlohmann::json::parse(fit_json(model).dump());
  EXPECT_EQ(again["outputs"]["q1"]["terms"][1]["coefficient"].get<double>(),
            model.outputs[0].report[1].coefficient);
}

TEST(FitJson, GivesAnglesInArcsecAndOthersInTheirOwnUnit) {
  auto model = a_model();
  model.outputs[0].channel = {"rx", "rad"};
  EXPECT_TRUE(fit_json(model)["outputs"]["rx"].contains("rmse_arcsec"));
  model.outputs[0].channel = {"force", "N"};
  EXPECT_TRUE(fit_json(model)["outputs"]["force"].contains("rmse_N"));
}

TEST(FitTable, IsAPageWithUnitsFiguresAndWarnings) {
  const std::string page = fit_table(a_model(), {.history = true});
  for (const auto* part : {"q1 ~ x + x^2 + T", "267 calibration rows", "mm/mm^2", "mm/degC",
                           "rms nm", "VIF", "enter", "blocks of time", "p-values after selection"})
    EXPECT_THAT(page, HasSubstr(part));
}

TEST(FitTable, NamesTheRuleAndTheStartThatWon) {
  calibration::FitOptions options;
  options.criterion = calibration::Criterion::aic;
  options.hierarchy = true;
  options.starts = 4;
  const auto model =
      *fit_formula(calibration::make_campaign({}), "q1 ~ poly(x, 3) + T + x:T", options);
  const std::string page = fit_table(model);
  for (const auto* part : {"stepwise, AIC, with hierarchy, best of 4 starts (seed 1)",
                           "best of 4 starts: ", "serial s.e.", "BIC", "all terms together: F"})
    EXPECT_THAT(page, HasSubstr(part));
  const auto json = fit_json(model);
  EXPECT_EQ(json["criterion"], "aic");
  EXPECT_EQ(json["hierarchy"], true);
  const auto& q1 = json["outputs"]["q1"];
  EXPECT_EQ(q1["starts"].size(), 4u);
  EXPECT_EQ(q1["starts"][0]["start"], "none");
  EXPECT_TRUE(q1["history"].back().contains("criterion_value"));
  EXPECT_EQ(q1["terms"][1]["unit"], "mm/mm");
  EXPECT_GT(q1["terms"][1]["standard_error_serial"].get<double>(), 0);
  const auto in = std::ranges::count_if(q1["terms"], [](const auto& term) { return term["in"]; });
  EXPECT_EQ(q1["covariance"].size(), static_cast<std::size_t>(in));
}

}  // namespace
}  // namespace driftwise::formats
