// AIC, BIC and hierarchy: against R's step(), add1() and drop1(), and by their properties.

#include "server/calibration/model/criterion.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <map>

#include "server/calibration/selection/hierarchy.h"
#include "tests/unit/calibration/campaign.h"
#include "tests/unit/calibration/criterion_golden.h"

namespace driftwise::calibration {
namespace {

TEST(Criterion, ChangeByATermIsTheDifferenceOfTheTwoValues) {
  // n = 20, RSS 9 with 3 coefficients, 5 with a fourth: F = 4 / (5 / 16) on 1 and 16
  const double f = (9.0 - 5.0) / (5.0 / 16);
  for (const double price : {2.0, std::log(20.0)}) {
    const double by_values = *information(5, 20, 4, price) - *information(9, 20, 3, price);
    EXPECT_NEAR(change_by_entering(f, 16, 20, price), by_values, 1e-12);
    EXPECT_NEAR(change_by_leaving(f, 16, 20, price), -by_values, 1e-12);
  }
}

TEST(Criterion, OfAnExactFitIsNoNumber) { EXPECT_FALSE(information(0, 10, 2, 2).has_value()); }

TEST(CriterionGolden, AgreesWithRStepByStepUnderAicBicAndHierarchy) {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) +
                     "/tests/data/stepwise_golden/criterion_golden.txt");
  const auto problems = read_criterion_problems(file);
  std::map<std::string, int> classes;
  for (const auto& problem : problems) {
    expect_agreement(problem);
    ++classes[problem.criterion];
    if (problem.options.hierarchy) ++classes["hierarchy"];
    if (!problem.options.weight_symbol.empty()) ++classes["weighted"];
    for (const auto& step : problem.path)
      if (step.front() == '-') {
        ++classes["with a removal"];
        break;
      }
  }
  for (const auto* kind : {"aic", "bic", "p"}) EXPECT_EQ(classes[kind], 40) << kind;
  EXPECT_GE(classes["hierarchy"], 60);
  EXPECT_GE(classes["weighted"], 25);
  EXPECT_GE(classes["with a removal"], 15);
}

std::vector<std::string> parent_names(const std::string& term) {
  std::vector<std::string> names;
  for (const auto& parent : parents_of(*formats::parse_term(term)))
    names.push_back(effects::notation(parent));
  return names;
}

TEST(Hierarchy, ParentsHaveOneFactorOrOnePowerLess) {
  using testing::ElementsAre;
  using testing::IsEmpty;
  EXPECT_THAT(parent_names("x"), IsEmpty());
  EXPECT_THAT(parent_names("x^3"), ElementsAre("x^2"));
  EXPECT_THAT(parent_names("x:t07"), ElementsAre("t07", "x"));
  EXPECT_THAT(parent_names("x^2:y:t01"), ElementsAre("x:y:t01", "x^2:t01", "x^2:y"));
  EXPECT_THAT(parent_names("x:rate(t01, 300 s)"), ElementsAre("rate(t01, 300 s)", "x"));
}

std::vector<std::string> names_in(const Model& model) {
  std::vector<std::string> names;
  for (const auto& term : model.outputs[0].terms) names.push_back(effects::notation(term));
  return names;
}

TEST(Hierarchy, HoldsInEveryModelOfRandomCampaigns) {
  int with_products = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    for (const Criterion criterion : {Criterion::p, Criterion::aic, Criterion::bic}) {
      FitOptions options;
      options.hierarchy = true;
      options.criterion = criterion;
      options.p_enter = 0.2;
      options.p_remove = 0.3;
      options.starts = 4;
      options.blocks = 0;
      const auto model = formats::fit_formula(make_campaign({.rows = 150, .seed = seed}),
                                              "q1 ~ poly(x, 4) + T + x:T + x^2:T", options);
      ASSERT_TRUE(model.has_value()) << model.error().message;
      const auto in = names_in(*model);
      for (const auto& term : model->outputs[0].terms)
        for (const auto& parent : parents_of(term)) {
          EXPECT_THAT(in, testing::Contains(effects::notation(parent))) << effects::notation(term);
          ++with_products;
        }
    }
  }
  EXPECT_GT(with_products, 200);  // or nothing was tested
}

TEST(Hierarchy, NamesAParentThatIsNotOffered) {
  FitOptions options;
  options.hierarchy = true;
  const auto model = formats::fit_formula(make_campaign({}), "q1 ~ x + x^2 + x:t01 + t02", options);
  ASSERT_TRUE(model.has_value());
  EXPECT_THAT(model->warnings, testing::Contains(testing::HasSubstr("hierarchy: x:t01 needs t01")));
  options.forced = {*formats::parse_term("x:t01")};
  const auto forced = formats::fit_formula(make_campaign({}), "q1 ~ x + x^2 + t02", options);
  ASSERT_FALSE(forced.has_value());
  EXPECT_EQ(forced.error().reason, "BAD_OPTIONS");
  EXPECT_THAT(forced.error().message, testing::HasSubstr("its parent t01 is not offered"));
}

TEST(Hierarchy, KeepsTheParentsOfAForcedTerm) {
  FitOptions options;
  options.hierarchy = true;
  options.forced = {*formats::parse_term("t03:t04")};
  const auto model = formats::fit_formula(make_campaign({}), "q1 ~ x + x^2 + T", options);
  ASSERT_TRUE(model.has_value()) << model.error().message;
  EXPECT_THAT(names_in(*model), testing::IsSupersetOf({"t03", "t04", "t03:t04"}));
}

}  // namespace
}  // namespace driftwise::calibration
