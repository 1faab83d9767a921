#pragma once
// Whose deviation a finding describes. A target follows the robot's own deviation and must not
// follow an instrument's error: the same readings taken for the other one move the target by twice
// their size.

#include <string>
#include <string_view>
#include <vector>

#include "server/diagnosis/answer/finding.h"

namespace driftwise::application {

enum class Side : std::uint8_t {
  robot,       // the target follows it
  instrument,  // taken off the readings; the target does not follow it
  rows,        // wrong rows or a broken sensor: no deviation at all
};
std::string_view to_string(Side side);

// name: a cause of the catalogue with its subject, "cyclic_error q1". An unknown one is the
// robot's.
Side side_of(std::string_view name);

// "thermal_lag t07"
std::string name_of(const diagnosis::Finding& finding);

// Of the finding's indistinguishable set, the causes of the other side. Empty: the data leave no
// doubt whose deviation it is. A step_change stands for itself: an instrument that jumps and a
// robot that slips read alike, and no cause of the catalogue is the robot's.
// Nor is a cyclic_error counted against a geometry_order: such a wave is as long as the travel.
std::vector<std::string> rivals_across(const diagnosis::Finding& finding);

}  // namespace driftwise::application
