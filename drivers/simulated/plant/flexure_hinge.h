#pragma once
// A flexure hinge: a blade of thickness t, width b, free length l, clamped at both ends and bent by
// an angle.

#include <numbers>

namespace driftwise::simulated {

struct FlexureHinge {
  double thickness_mm = 0, width_mm = 0, length_mm = 0;
  double youngs_gpa = 0;

  double bending_nmm2() const {  // E I
    return youngs_gpa * 1e3 * width_mm * thickness_mm * thickness_mm * thickness_mm / 12;
  }
  double turning_nmm_rad() const { return bending_nmm2() / length_mm; }

  // Elongation per force, mm/N, at a bend of angle_rad under tension_n. Straight: l / (E b t). A
  // bent blade is an arc that straightens as it is pulled: angle^2 l^3 / (45 E I) from the bending
  // energy of an arc whose ends keep their direction; pulling stiffens it, pushing softens it, by 1
  // + F / F_c with Euler's load of a clamped column, F_c = 4 pi^2 E I / l^2.
  double give_mm_n(double angle_rad, double tension_n) const {
    const double straight = length_mm / (youngs_gpa * 1e3 * width_mm * thickness_mm);
    const double l2 = length_mm * length_mm;
    const double arc = angle_rad * angle_rad * l2 * length_mm / (45 * bending_nmm2());
    const double euler_n = 4 * std::numbers::pi * std::numbers::pi * bending_nmm2() / l2;
    return straight + arc / (1 + tension_n / euler_n);
  }
};

}  // namespace driftwise::simulated
