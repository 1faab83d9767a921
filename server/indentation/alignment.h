#pragma once
// Alignment of two robots' frames by touching: a plane through touched points, the correction of
// the work-piece's tilts, and when it is good enough. Pure.
//
// The tool is at (x, y), mm, in the frame of the robot above; height is what the robot below had
// moved up when they touched. A work-piece tilted by rx, ry (small, right-handed) stands higher by
// y tan rx - x tan ry there, so it touches at height = c - y tan rx + x tan ry.
// Source: E. Lubrano, EPFL thesis 5098 (2011), section 8.2.3. Its second printed equation holds for
// none of its printed points: zC - zA mixes both tilts.

#include <span>
#include <string>
#include <vector>

#include "server/core/result.h"

namespace driftwise::indentation {

struct TouchPoint {
  double x_mm = 0, y_mm = 0;
  double height_mm = 0;
  double u_nm = 72;  // standard uncertainty of the height: 250 nm over the root of 12
};

struct TouchPlane {
  double c_mm = 0, rx_arcsec = 0, ry_arcsec = 0;
  double u_rx_arcsec = 0, u_ry_arcsec = 0;  // from the points' u
  double largest_residual_nm = 0;
  double spread_nm = 0;  // highest minus lowest contact
};

// Weighted least squares. Errors, invalid_argument: TOO_FEW_POINTS (fewer than 3), POINTS_ON_A_LINE
// (the points lie on a line within 2 % of their extent: one tilt is not determined), BAD_VALUE (not
// finite, u not above 0, a slope of 45 degrees or more).
Result<TouchPlane> fit_plane(std::span<const TouchPoint> points);

struct AlignmentRule {
  double accept_nm = 500;  // contacts agree to it
  int most_corrections = 3;
};

struct AlignmentStep {
  enum class Kind { accepted, correct, refused };
  Kind kind = Kind::correct;
  TouchPlane plane{};
  double rx_arcsec = 0, ry_arcsec = 0;  // wanted tilts of the work-piece from now on
  std::string sentence{};               // figures; refused: what to do
};

// corrections: made so far. rx_arcsec, ry_arcsec: tilts that the robot below was told for these
// points. After a correction the caller touches at shifted places: a fresh surface, and no
// judgement on the points that the correction was made from.
Result<AlignmentStep> next_alignment(const AlignmentRule& rule, int corrections, double rx_arcsec,
                                     double ry_arcsec, std::span<const TouchPoint> points);

}  // namespace driftwise::indentation
