#pragma once
// indentation.toml: what an operator wants of an indentation. docs/indentation.md has the keys.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "server/indentation/procedure.h"

namespace driftwise::formats {

struct IndentationFile {
  std::string name{};
  indentation::ProcedureRules rules{};
  indentation::ToolRules tool{};
  double wanted_um = 1;
  std::string above = "mn", below = "ma";  // ids of the robots
  int readings = 3;                        // of the controller's position, per look
  int poses = 8;                           // of the interferometers, per place
  std::vector<std::string> temperatures{};

  // Where motor coordinates come from: the promoted plan's joint target, or nominal geometry (raw
  // motor coordinates) with the reason that the operator states.
  bool by_plan = true;
  std::string reason{};
  struct Delta {  // robot above: carriages on vertical axes above the platform
    double radius_mm = 0, arm_mm = 0;
    std::vector<double> azimuth_deg{0, 120, 240};
  } delta{};
  struct Screws {  // robot below: vertical screws under the end-effector
    double radius_mm = 0;
    std::vector<double> azimuth_deg{0, 120, 240};
  } screws{};
};

// Errors, invalid_argument, with file:line and key: TOML_SYNTAX, UNKNOWN_KEY, MISSING_KEY,
// WRONG_TYPE, OUT_OF_RANGE, BAD_VALUE, REASON_REQUIRED (geometry without a reason).
Result<IndentationFile> read_indentation_file(std::string_view text, const std::string& file_name);

}  // namespace driftwise::formats
