// Places of the study's file, by hand: touches at 1 and -1 mm, shifted by 0.1 mm in y after each of
// three corrections.
#include "server/indentation/planned_places.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace driftwise::indentation {
namespace {

ProcedureRules rules() {
  ProcedureRules rules;
  rules.approach = {.depart_mm = 1.555, .highest_mm = 1.645};
  rules.press_mm = 0.00075;
  rules.zero_x_mm = 0.2;
  rules.alignment.most_corrections = 3;
  rules.indents = {{"x250", Line::x, 250, false}, {"y1000", Line::y, 1000, false}};
  return rules;
}

TEST(PlannedPlaces, AreTheTouchesAfterEachCorrectionTheZeroAndTheIndents) {
  const auto places = planned_places(rules());
  ASSERT_EQ(places.size(), 4U * 3 + 1 + 2);
  const auto at = [&](const std::string& name) {
    const auto found = std::ranges::find(places, name, &PlannedPlace::name);
    EXPECT_NE(found, places.end()) << name;
    return found == places.end() ? PlannedPlace{} : *found;
  };
  EXPECT_DOUBLE_EQ(at("[align] point 1, -1").y_mm, -1);
  EXPECT_DOUBLE_EQ(at("[align] point 1, -1 after correction 3").x_mm, 1);
  EXPECT_DOUBLE_EQ(at("[align] point 1, -1 after correction 3").y_mm, -0.7);
  EXPECT_DOUBLE_EQ(at("indent x250").x_mm, 0.45);
  EXPECT_DOUBLE_EQ(at("indent y1000").y_mm, 1);
  EXPECT_DOUBLE_EQ(at("zero_mm").x_mm, 0.2);
}

// Three corrections of 3 mm: the procedure would stop at 10 mm after real contacts.
TEST(PlannedPlaces, ShowAShiftThatLeavesTheWorkPiece) {
  auto far = rules();
  far.shift_y_mm = 3;
  const auto places = planned_places(far);
  EXPECT_DOUBLE_EQ(std::ranges::max(places, {}, &PlannedPlace::y_mm).y_mm, 10);
}

TEST(PlannedHeights, ReachFromTheRetractToThePressedIndent) {
  const auto heights = planned_heights(rules());
  const auto [low, high] = std::ranges::minmax(heights, {}, &PlannedHeight::height_mm);
  EXPECT_DOUBLE_EQ(low.height_mm, 0.955);
  EXPECT_DOUBLE_EQ(high.height_mm, 1.64575);
}

}  // namespace
}  // namespace driftwise::indentation
