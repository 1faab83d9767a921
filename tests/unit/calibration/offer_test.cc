#include "server/calibration/offer.h"

#include <gmock/gmock.h>

#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"
#include "tests/unit/calibration/campaign.h"

namespace driftwise::calibration {
namespace {

struct Fixture {
  Dataset data = make_campaign({.rows = 600});
  FitOptions options;
  Model model;
  explicit Fixture(const std::string& formula) {
    options.candidates = *formats::Formula::parse(formula)->expand(data);
    model = *fit(data, options);
  }
};

TEST(Offers, AreTheThreeOfThePublishedStudy) {
  const Fixture fixture("q1 ~ x + x^2 + t01 + t02");
  const auto offers = published_offers(fixture.data, fixture.options.candidates, 600);
  ASSERT_EQ(offers.size(), 3u);
  std::vector<std::string> names;
  for (const auto& offer : offers)
    for (const auto& term : offer.terms) names.push_back(effects::notation(term));
  EXPECT_THAT(names, testing::ElementsAre("x:t01", "x:t02", "rate(t01, 600 s)", "rate(t02, 600 s)",
                                          "rate2(t01, 600 s)", "rate2(t02, 600 s)", "x^3", "x^4"));
}

TEST(Offers, CrossAForceWithThePositionToo) {
  Fixture fixture("q1 ~ x + t01");
  DatasetColumn force{{"force", "N"}, std::vector<double>(fixture.data.rows, 0.5)};
  fixture.data.columns.push_back(std::move(force));
  fixture.options.candidates =
      *formats::Formula::parse("q1 ~ x + F + F^2 + t01")->expand(fixture.data);
  const auto offers = published_offers(fixture.data, fixture.options.candidates, 600);
  ASSERT_FALSE(offers.empty());
  EXPECT_EQ(offers.front().name, "cross terms position x force");
  ASSERT_EQ(offers.front().terms.size(), 1u);
  EXPECT_EQ(effects::notation(offers.front().terms.front()), "x:force");
}

TEST(Offers, SayWhatATermThatMattersIsWorth) {
  const Fixture fixture("q1 ~ x + t01 + t02");  // x^2 is missing: 2e-5 * 16 mm^2 = 320 nm
  const auto results = weigh_offers(fixture.data, fixture.options, fixture.model,
                                    {{"square", {*formats::parse_term("x^2")}}});
  ASSERT_TRUE(results.has_value()) << results.error().message;
  const auto& result = results->at(0);
  EXPECT_TRUE(result.taken_any());
  EXPECT_LT(result.best_p, 1e-50);
  EXPECT_GT(*result.u90_validation_before, 1e-4);
  EXPECT_LT(*result.u90_validation_after, 7e-6);
  EXPECT_LT(*result.u90_blocks_after, *result.u90_blocks_before / 10);
  EXPECT_LT(*result.a90_blocks_after, *result.a90_blocks_before / 10);
  EXPECT_LT(*result.a90_validation_after, 7e-6);
}

TEST(Offers, SayWhatForcingAUselessTermWouldDo) {
  const Fixture fixture("q1 ~ x + x^2 + t01 + t02");
  const auto results = weigh_offers(fixture.data, fixture.options, fixture.model,
                                    {{"order", {*formats::parse_term("x^4")}}});
  ASSERT_TRUE(results.has_value());
  EXPECT_NEAR(*results->at(0).u90_validation_forced / *results->at(0).u90_validation_before, 1,
              0.05);
}

}  // namespace
}  // namespace driftwise::calibration
