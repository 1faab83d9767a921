#pragma once
// Known weights on a pan, a wire over two pulleys, a pull upwards on the platform.
//
// Weights go on and off one at a time; afterwards the pan swings for a while. The pulleys rub: the
// wire's tension T may differ from the weight F by the friction's share of it, and where it stands
// within that band depends on which way the wire last moved: T follows the wire's own stiffness
// until it slips (a play). Weights are declared with the study's g; here another one acts.

#include "drivers/simulated/plant/micro_nano/micro_nano_parameters.h"

namespace driftwise::simulated {

class LoadRig {
 public:
  // wire_mm as in tension_n, at the start: the empty pan hangs there without friction.
  LoadRig(const LoadParameters& parameters, double wire_mm);

  // Of the wire, N. wire_mm: between platform and pulley at that instant. For instants since the
  // last settle(), in which the wire has moved one way.
  double tension_n(double time_s, double wire_mm) const;
  // The state is taken over: called before a command changes motion or weights.
  void settle(double time_s, double wire_mm);

  void set_newton(double newton, double now_s);
  void set_jammed(bool jammed, double now_s);
  LoadState state(double now_s) const;

 private:
  double declared_n(double time_s) const;     // hanging just then
  double hanging_n(double declared_n) const;  // true pull of weights and pan
  double change_s() const;                    // how long the present change takes

  LoadParameters parameters_;
  double from_n_ = 0, to_n_ = 0, start_s_ = -1e9;
  bool jammed_ = false;
  double settled_tension_n_ = 0, settled_wire_mm_ = 0;
};

}  // namespace driftwise::simulated
