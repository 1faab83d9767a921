#include "server/indentation/alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace driftwise::indentation {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Heights of contact over a plane tilted by rx, ry: what the definition says.
std::vector<TouchPoint> touches(double rx_deg, double ry_deg,
                                std::vector<std::pair<double, double>> places) {
  std::vector<TouchPoint> points;
  for (const auto& [x, y] : places)
    points.push_back(
        {.x_mm = x,
         .y_mm = y,
         .height_mm = 0.5 - y * std::tan(rx_deg * kDegree) + x * std::tan(ry_deg * kDegree)});
  return points;
}
const std::vector<std::pair<double, double>> kStudy{{1, 1}, {1, -1}, {-1, -1}};

TEST(TouchPlane, FindsTheStudysTilts) {
  // 0.15 and 0.36 degrees: 540 and 1296 arcsec, 5.24 and 12.57 um over 2 mm.
  const auto points = touches(0.15, 0.36, kStudy);
  EXPECT_NEAR((points[1].height_mm - points[0].height_mm) * 1e3, 5.24, 0.005);
  EXPECT_NEAR((points[1].height_mm - points[2].height_mm) * 1e3, 12.57, 0.005);
  const auto plane = fit_plane(points);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->rx_arcsec, 540, 1e-6);
  EXPECT_NEAR(plane->ry_arcsec, 1296, 1e-6);
  EXPECT_NEAR(plane->c_mm, 0.5, 1e-12);
  // Two heights of 72 nm over 2 mm: 72 sqrt 2 / 2e6 rad.
  EXPECT_NEAR(plane->u_rx_arcsec, 72 * std::sqrt(2) / 2e6 / std::numbers::pi * 180 * 3600, 1e-3);
}

TEST(TouchPlane, FindsTheSameAtAnySpacingAndPlace) {
  const auto plane =
      fit_plane(touches(-0.5, 0.02, {{3.1, 1.1}, {3.0, -0.2}, {2.2, 0.4}, {2.7, 0.3}}));
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->rx_arcsec, -1800, 1e-6);
  EXPECT_NEAR(plane->ry_arcsec, 72, 1e-6);
  EXPECT_NEAR(plane->c_mm, 0.5, 1e-11);
  EXPECT_LT(plane->largest_residual_nm, 1e-6);
}

TEST(TouchPlane, RefusesPointsOnALineInWords) {
  const auto line = fit_plane(touches(0.1, 0.1, {{-1, -1}, {0, 0.001}, {1, 1}}));
  ASSERT_FALSE(line);
  EXPECT_EQ(line.error().reason, "POINTS_ON_A_LINE");
  EXPECT_NE(line.error().message.find("on one line"), std::string::npos);
  EXPECT_EQ(fit_plane(touches(0, 0, {{1, 1}, {1, 1}, {1, 1}})).error().reason, "POINTS_ON_A_LINE");
  EXPECT_EQ(fit_plane(touches(0, 0, {{1, 1}, {1, 0}})).error().reason, "TOO_FEW_POINTS");
  auto points = touches(0, 0, kStudy);
  points[1].height_mm = NAN;
  EXPECT_EQ(fit_plane(points).error().reason, "BAD_VALUE");
}

TEST(Alignment, CorrectsByAsMuchTheOtherWayAndAcceptsWhatAgrees) {
  const auto first = next_alignment({}, 0, 100, 0, touches(0.15, 0.36, kStudy));
  ASSERT_TRUE(first);
  EXPECT_EQ(first->kind, AlignmentStep::Kind::correct);
  EXPECT_NEAR(first->rx_arcsec, 100 - 540, 1e-6);
  EXPECT_NEAR(first->ry_arcsec, -1296, 1e-6);
  // 52 arcsec over 2 mm are the 500 nm of the study.
  EXPECT_EQ(next_alignment({}, 1, 0, 0, touches(51 / 3600.0, 0, kStudy))->kind,
            AlignmentStep::Kind::accepted);
  EXPECT_EQ(next_alignment({}, 1, 0, 0, touches(53 / 3600.0, 0, kStudy))->kind,
            AlignmentStep::Kind::correct);
}

// Two steps of 250 nm are 500 nm, whatever the last digits of heights in mm make of them.
TEST(Alignment, AcceptsContactsThatDifferByJustTheLimit) {
  auto points = touches(0, 0, kStudy);
  for (auto& point : points) point.height_mm = 1.555 + 100 * 0.00025;
  points[0].height_mm = 1.555 + 102 * 0.00025;
  EXPECT_EQ(next_alignment({}, 1, 0, 0, points)->kind, AlignmentStep::Kind::accepted);
  points[0].height_mm = 1.555 + 103 * 0.00025;
  EXPECT_EQ(next_alignment({}, 1, 0, 0, points)->kind, AlignmentStep::Kind::correct);
}

TEST(Alignment, RefusesAfterThreeCorrectionsAndSaysWhatToDo) {
  const auto step = next_alignment({}, 3, 0, 0, touches(0.15, 0.36, kStudy));
  ASSERT_TRUE(step);
  EXPECT_EQ(step->kind, AlignmentStep::Kind::refused);
  EXPECT_NE(step->sentence.find("Check its model"), std::string::npos) << step->sentence;
}

}  // namespace
}  // namespace driftwise::indentation
