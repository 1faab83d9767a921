#pragma once
// Force balance of a Vickers pyramid between a plastic substrate and a servo that holds still.
// Newton, nanometres, seconds; no plant, no clock.
//
// Substrate, loading: F = H A(h), A = 24.5 h^2 + 2 pi R h: the pyramid of 136 degrees with an edge
// rounded to R (Fischer-Cripps, Nanoindentation, section 2.3). Unloading: the elastic part of the
// depth comes back, linearly. Robot: flexures within the dead zone of the servo's proportional
// part, the servo beyond it, and an integrator that pushes back.

#include "drivers/simulated/plant/two_robots/contact_parameters.h"

namespace driftwise::simulated {

struct Crater {
  double x_mm = 0, y_mm = 0;  // on the substrate, from its centre
  double depth_nm = 0;        // deepest so far
  double force_n = 0;         // at that depth
};

// Corner to corner: 7 times the depth (ISO 6507-1, 136 degrees: 2 sqrt 2 tan 68 deg).
double diagonal_um(const Crater& crater);

class HoldingServo {
 public:
  explicit HoldingServo(const HoldingParameters& parameters) : p_(parameters) {}

  // Force that holds the stage pushed by so much.
  double resisting_n(double push_nm) const;
  // Place under a force.
  double push_nm(double force_n) const;
  void integrate(double push_nm, double step_s);

 private:
  HoldingParameters p_;
  double integral_n_ = 0;
};

struct Balance {
  double push_nm = 0, force_n = 0;
};

// overlap_nm: how far the substrate is above where the tip would be without contact; below 0: free.
// The crater gets deeper where the force asks for it.
Balance balance(double overlap_nm, const ContactParameters& contact, const HoldingServo& servo,
                Crater& crater);

}  // namespace driftwise::simulated
