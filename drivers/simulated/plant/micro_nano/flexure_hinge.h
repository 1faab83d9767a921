#pragma once
// A flexure hinge: a blade of thickness t, width b, free length l, clamped at both ends and bent by
// an angle.

#include <algorithm>

namespace driftwise::simulated {

struct FlexureHinge {
  double thickness_mm = 0, width_mm = 0, length_mm = 0;
  double youngs_gpa = 0;

  double bending_nmm2() const {  // E I
    return youngs_gpa * 1e3 * width_mm * thickness_mm * thickness_mm * thickness_mm / 12;
  }
  double turning_nmm_rad() const { return bending_nmm2() / length_mm; }

  // Elongation per force (secant), mm/N, at a bend of angle_rad under tension_n along the bar that
  // the far end is fixed to. Straight: l / (E b t). A bent blade is an arc that can be pulled
  // straight: there are angle^2 l / 6 to be had, beginning with angle^2 l^3 / (45 E I) per newton
  // (the bending energy of an arc whose ends keep their directions), and as one mode of bending 1 -
  // (1 + F / F1)^-2 of it under F, with F1 = 15 E I / l^2 from these two. So tension stiffens,
  // pressure softens.
  double give_mm_n(double angle_rad, double tension_n) const {
    const double straight = length_mm / (youngs_gpa * 1e3 * width_mm * thickness_mm);
    const double slack_mm = angle_rad * angle_rad * length_mm / 6;
    const double mode_n = 15 * bending_nmm2() / (length_mm * length_mm);
    const double share = std::max(tension_n / mode_n, -0.9);  // beyond, a real blade would buckle
    return straight + slack_mm * (2 + share) / (mode_n * (1 + share) * (1 + share));
  }
};

}  // namespace driftwise::simulated
