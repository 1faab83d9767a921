#pragma once
// Places and heights that an indentation goes to when all goes as planned: what is asked of the
// cell before anything moves. Pure.

#include <string>
#include <vector>

#include "server/indentation/procedure.h"

namespace driftwise::indentation {

struct PlannedPlace {
  std::string name{};  // "[align] point 1, -1 after correction 2", "indent x250", "zero_mm"
  double x_mm = 0, y_mm = 0;
};

// Of the robot above. The touched places once for each correction that may be needed: one that
// cannot be reached would show after real contacts only.
std::vector<PlannedPlace> planned_places(const ProcedureRules& rules);

struct PlannedHeight {
  std::string name{};  // "[approach] highest_mm + press_mm"
  double height_mm = 0;
};

// Of the robot below, untilted: retracted, where it begins, and the highest, pressed in.
std::vector<PlannedHeight> planned_heights(const ProcedureRules& rules);

}  // namespace driftwise::indentation
