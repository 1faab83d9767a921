#include "server/effects/term_evaluator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/effects/term_order.h"

namespace driftwise::effects {
namespace {

std::vector<Term> some_terms() {
  return {Term{},
          {{Power{"x", 1}}},
          {{Power{"x", 3}}},
          {{Power{"x", 1}, Power{"t01", 1}}},
          {{Call{"rate", {"t01"}, {{300, "s"}}}}},
          {{Power{"x", 2}, Call{"lag", {"t01"}, {{1830, "s"}}}}},
          datum_term(2)};
}

TEST(TermEvaluator, GivesTheSameBitsByRowsAndByBlocks) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> time, x, t01, datum;
  for (int i = 0; i < 500; ++i) {
    time.push_back(time.empty() ? 0 : time.back() + 1 + std::abs(normal(random)) * 20);
    x.push_back(4 * normal(random));
    t01.push_back(i == 77 ? std::nan("") : 21 + normal(random));
    datum.push_back(i < 250 ? 1 : 2);
  }
  auto rows = TermEvaluator::create(some_terms(), {"x", "t01", "datum"});
  ASSERT_TRUE(rows.has_value());
  auto blocks = *rows;
  const Eigen::MatrixXd whole = blocks.block(time, {x, t01, datum}, time.size());
  std::vector<double> out(rows->columns());
  for (std::size_t i = 0; i < time.size(); ++i) {
    rows->step(time[i], std::vector{x[i], t01[i], datum[i]}, out);
    for (std::size_t j = 0; j < out.size(); ++j) {
      const double other = whole(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      EXPECT_TRUE(out[j] == other || (std::isnan(out[j]) && std::isnan(other))) << i << " " << j;
    }
  }
}

TEST(TermEvaluator, ContinuesABlockWhereTheLastOneEnded) {
  std::vector<double> time, t;
  for (int i = 0; i < 100; ++i) time.push_back(10.0 * i), t.push_back(std::sin(0.1 * i));
  const std::vector<Term> terms = {{{Call{"lag", {"t01"}, {{100, "s"}}}}}};
  auto whole = TermEvaluator::create(terms, {"t01"});
  auto parts = *whole;
  const Eigen::MatrixXd all = whole->block(time, {t}, 100);
  const std::span<const double> times(time), values(t);
  parts.block(times.first(37), {values.first(37)}, 37);
  const Eigen::MatrixXd rest = parts.block(times.subspan(37), {values.subspan(37)}, 63);
  EXPECT_EQ(rest, all.bottomRows(63));
}

TEST(TermEvaluator, ServesDatumConstantsAsNothingWithoutADatumChannel) {
  auto evaluator = TermEvaluator::create({datum_term(2)}, {"x"});
  std::vector<double> out(1, 7);
  evaluator->evaluate(std::vector{1.0}, out);
  EXPECT_EQ(out[0], 0);
}

TEST(TermEvaluator, NamesTheChannelThatIsMissing) {
  const auto evaluator = TermEvaluator::create(some_terms(), {"x"});
  ASSERT_FALSE(evaluator.has_value());
  EXPECT_EQ(evaluator.error().reason, "UNKNOWN_CHANNEL");
  EXPECT_NE(evaluator.error().message.find("x:t01 needs channel 't01'"), std::string::npos);
}

}  // namespace
}  // namespace driftwise::effects
