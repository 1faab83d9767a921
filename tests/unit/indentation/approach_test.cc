#include "server/indentation/approach.h"

#include <gtest/gtest.h>

#include <cmath>

namespace driftwise::indentation {
namespace {

using Kind = Approach::Next::Kind;

// A surface at a height: every micrometre beyond pushes the axes by 900 nm.
Approach::Next touched(Approach& approach, double surface_mm) {
  Approach::Next next = approach.begin();
  while (next.kind == Kind::rest || next.kind == Kind::move || next.kind == Kind::look) {
    const double overlap_mm = next.kind == Kind::rest ? -1 : next.height_mm - surface_mm;
    const double shift_nm = -900e3 * std::max(0.0, overlap_mm);
    next = *approach.next(Eigen::MatrixXd::Constant(3, 3, 30 + shift_nm));
  }
  return next;
}

TEST(Approach, FindsTheSurfaceWithinOneStep) {
  auto approach = *Approach::create({.depart_mm = -0.01, .highest_mm = 0.02});
  const auto end = touched(approach, 0.00310);
  EXPECT_EQ(end.kind, Kind::contact);
  EXPECT_NEAR(end.height_mm, 0.00310, 0.00025);
  EXPECT_NEAR(end.u_nm, 72.17, 0.01);  // 250 / sqrt(12)
  EXPECT_GE(approach.steps(), 40);
}

// Beyond the surface by so much, and with the sign that each asks for.
TEST(Approach, TakesNoHeightFromAContactBeforeTheFirstStep) {
  for (const double beyond_mm : {0.00004, 0.0002, 0.002, 0.02}) {
    auto approach = *Approach::create({.depart_mm = 1, .highest_mm = 1.1});
    const auto end = touched(approach, 1 - beyond_mm);
    EXPECT_EQ(end.kind, beyond_mm < 0.001 ? Kind::touching : Kind::abort) << beyond_mm;
    EXPECT_EQ(approach.steps(), 0);
    EXPECT_NE(end.why.find("begin lower"), std::string::npos) << end.why;
  }
}

TEST(Approach, ReadsTheRestBeforeItMoves) {
  auto approach = *Approach::create({.depart_mm = 1, .highest_mm = 1.1});
  Approach::Next next = approach.begin();
  int looks = 0;
  for (; next.kind == Kind::rest; ++looks) next = *approach.next(Eigen::MatrixXd::Zero(1, 3));
  EXPECT_EQ(looks, 5);
  EXPECT_EQ(next.kind, Kind::move);
  EXPECT_EQ(next.height_mm, 1);
}

TEST(Approach, EndsAtTheHighestPlaceWithFiguresWhenNothingIsThere) {
  auto approach = *Approach::create({.depart_mm = 0, .highest_mm = 0.001});
  const auto end = touched(approach, 1);
  EXPECT_EQ(end.kind, Kind::no_contact);
  EXPECT_EQ(approach.steps(), 4);
  EXPECT_NE(end.why.find("no contact in 4 steps up to 0.001 mm"), std::string::npos) << end.why;
}

TEST(Approach, NeverMovesBetweenTheTwoWindowsOfAContact) {
  auto approach = *Approach::create({.depart_mm = 0, .highest_mm = 1});
  for (int i = 0; i < 5; ++i) (void)*approach.next(Eigen::MatrixXd::Zero(1, 3));
  EXPECT_EQ(approach.next(Eigen::MatrixXd::Zero(1, 3))->kind, Kind::move);
  EXPECT_EQ(approach.next(Eigen::MatrixXd::Constant(1, 3, -200))->kind, Kind::look);
  EXPECT_EQ(approach.next(Eigen::MatrixXd::Zero(1, 3))->kind, Kind::move);  // it was a knock
}

TEST(Approach, RefusesARuleThatCannotBeMeantInWords) {
  EXPECT_EQ(Approach::create({.depart_mm = 1, .highest_mm = 1}).error().reason, "BAD_RULE");
  EXPECT_EQ(Approach::create({.highest_mm = 1, .step_mm = 0}).error().reason, "BAD_RULE");
  EXPECT_EQ(Approach::create({.contact = {.threshold_nm = 2000}, .highest_mm = 1}).error().reason,
            "BAD_RULE");
}

}  // namespace
}  // namespace driftwise::indentation
