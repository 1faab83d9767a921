#pragma once
// Quantities of a cell's design that a study changes by name, with their present values. Pure.

#include <functional>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/compensation/snapshot.h"
#include "server/core/description/cell_description.h"

namespace driftwise::compensation {

enum class DesignKind : std::uint8_t {
  instrument,  // a declared uncertainty of the cell file, or a lever arm
  expansion,   // how far the robot follows a thermometer, times today's
  line,        // a line of the budget, times today's
};

struct DesignQuantity {
  std::string subject;  // a channel's symbol ("x", "t04"), or a line ("residual")
  std::string key;      // "u_length_nm", "offset_y_mm", "expansion", "factor"
  DesignKind kind = DesignKind::instrument;
  double value = 0;                                   // today's; 1 of a factor
  double low = 0, high = 1e9;                         // what it may be
  std::string what;                                   // "noise of one length reading": for people
  std::function<void(CellDescription&, double)> set;  // of an instrument

  std::string name() const { return subject + "." + key; }
};

// In the order of the cell's devices, then the thermometers that the model reads, then the lines.
std::vector<DesignQuantity> design_quantities(const calibration::Model& model,
                                              const CellDescription& cell);

}  // namespace driftwise::compensation
