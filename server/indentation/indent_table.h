#pragma once
// The table of indents: distances from the first indent as a microscope shows them, against what
// the robot was told, with the uncertainty of the marking, the force, and the share of the robot's
// parasitic rotations at the tool. Pure.
// Source: E. Lubrano, EPFL thesis 5098 (2011), sections 8.2.5 and 8.4, table 8.1.

#include <span>
#include <string>
#include <vector>

#include "server/core/result.h"

namespace driftwise::indentation {

enum class Line { x, y };

struct Indent {
  std::string id{};
  Line line = Line::x;
  double wanted_um = 0;                 // distance from the first indent along the line
  double rx_arcsec = 0, ry_arcsec = 0;  // of the robot that carries the tool, there
  double measured_um = 0;               // distance from the first indent in the microscope
  double pixel_nm = 0, marking_px = 0;  // of the picture; how well an indent is marked, +-
  int pictures_joined = 0;              // further pictures between the two indents
  double diagonal_um = 0;               // 0: not measured
};

struct ToolRules {
  double lever_mm = 100;  // tip below the centre that was calibrated: l + r
  double hardness_hv = 170;
};

struct IndentRow {
  Indent indent{};
  double error_um = 0;
  double half_width_um = 0;  // U = 2 m p + k p / 2, half-widths added
  double u_um = 0;           // standard uncertainty, GUM: p sqrt(2 m^2 / 3 + k / 12)
  double rotations_um = 0;   // size of lever x (rx, ry)
  double lever_um = 0;       // of the error: what a rigid tool adds along the line
  double rest_um = 0;        // error - lever
  double force_mN = 0;       // by the diagonal; 0: none
};

// F = HV d^2 / 0.1891, in mN. ISO 6507-1.
double vickers_force_mN(double hardness_hv, double diagonal_um);

// Errors, invalid_argument: NO_ROWS; BAD_VALUE with its id: not finite, wanted_um not above 0,
// pixel or marking below 0; DUPLICATE_ID; BAD_VALUE of the tool.
Result<std::vector<IndentRow>> indent_table(std::span<const Indent> indents, const ToolRules& tool);

}  // namespace driftwise::indentation
