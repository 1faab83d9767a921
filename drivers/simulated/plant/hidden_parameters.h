#pragma once
// What a plant file hides in its plant: [hidden.<name>] with a kind. None is there by default, and
// then the plant is bit for bit what it is without this file. Keys, sources and what each looks
// like in data: docs/plants/hidden.md.
//
// axis, beam: counted from 0 here, from 1 in the file. Hours count from the start of the plant's
// story.

#include <array>
#include <string>
#include <variant>
#include <vector>

namespace driftwise::simulated {

// A plate that touches a part through a film: heat soaks through its thickness.
struct HiddenSlab {
  int axis = 0, part = 0;
  double thickness_mm = 0, film_w_m2k = 0;
  double density_kg_m3 = 0, heat_capacity_j_kgk = 0, conductivity_w_mk = 0, expansion_per_k = 0;
  bool bends = false;    // its faces differ: sag over span_mm; else it grows over length_mm
  double length_mm = 0;  // or the span
};

// A drive that turns travel into heat: drive, then carrier, then a part of the plant.
struct HiddenMotorHeat {
  int axis = 0, part = 0;
  double heat_j_per_mm = 0, drive_j_k = 0, carrier_j_k = 0, link_w_k = 0, sink_w_k = 0;
  double length_mm = 0, expansion_per_k = 0;  // of the carrier
};

// Rolling or sliding contact beside a structure that gives: parallel spring-sliders (Iwan 1966).
struct HiddenFriction {
  int axis = 0;
  double friction_n = 0, stiffness_n_um = 0, presliding_um = 0;
};

// Glue or polymer in the way of a motion: Kelvin-Voigt elements over two decades of time.
struct HiddenViscoelastic {
  int axis = 0;
  double share_ppm = 0;  // of a move that comes late
  std::array<double, 3> times_s{};
};

// A scale's two signals as they leave its grating: offset, unequal amplitudes, not quite a quarter.
struct HiddenScaleSignals {
  int axis = 0;
  double period_nm = 0, offset_pct = 0, amplitude_pct = 0, phase_deg = 0;
};

// Light that took another way than it should, beside the light that measures.
struct HiddenFringeMixing {
  int beam = 0;
  double ghost = 0, mixing = 0;  // amplitudes against the measuring light
};

// A laser tube that is not locked warms up and its wavelength with it.
struct HiddenLaserDrift {
  int beam = 0;
  double ppm = 0, warm_up_h = 0;
};

struct HiddenLostFringe {
  int beam = 0;
  double at_h = 0, half_waves = 0;
};

// A screwed or glued joint gives way once.
struct HiddenSlip {
  int axis = 0;
  double at_h = 0, nm = 0;
};

// The level control of an air-sprung table: leaks down, is filled up, and the beam sees it.
struct HiddenLevelControl {
  int beam = 0;
  double leak_s = 0, fill_s = 0, nm = 0, lag_s = 0;
};

// A particle on a guide: a bump where it lies.
struct HiddenParticle {
  int axis = 0;
  double at_mm = 0, half_width_mm = 0, nm = 0;
};

// A ball on a flat in the line of the load (Hertz): approach with the 2/3 power of the force.
struct HiddenBallContact {
  int axis = 0;
  double radius_mm = 0, youngs_gpa = 0;
};

// Readings that are wrong by themselves for a moment, at random instants.
struct HiddenGlitches {
  int beam = 0;
  double per_hour = 0, nm = 0, seconds = 0;
};

// A fan that is switched on: eddies in the beam from then on.
struct HiddenFan {
  int beam = 0;
  double at_h = 0, eddy_k = 0, eddy_s = 0;
};

// More air between head and mirror than anybody typed in.
struct HiddenDeadPath {
  int beam = 0;
  double mm = 0;
};

struct HiddenWeatherFront {
  double at_h = 0, over_h = 0, hpa = 0;
};

// Micro-Nano: where the beam meets the cube, beyond what is known, and how it looks at it.
struct HiddenBeamPlace {
  int beam = 0;
  double u_mm = 0, v_mm = 0, angle_arcsec = 0;
};

struct HiddenThermometer {
  enum class Fault { stuck, jump, gain, swapped };
  int input = 0, other = 0;  // scanner inputs
  Fault fault = Fault::stuck;
  double at_h = 0;
  double size = 0;  // jump: ohm of a bad joint; gain: factor on the reading's distance from R0
};

using HiddenEffect =
    std::variant<HiddenSlab, HiddenMotorHeat, HiddenFriction, HiddenViscoelastic,
                 HiddenScaleSignals, HiddenFringeMixing, HiddenLaserDrift, HiddenLostFringe,
                 HiddenSlip, HiddenLevelControl, HiddenParticle, HiddenBallContact, HiddenGlitches,
                 HiddenFan, HiddenDeadPath, HiddenWeatherFront, HiddenBeamPlace, HiddenThermometer>;

struct Hidden {
  std::string name{};
  HiddenEffect effect{};
};

}  // namespace driftwise::simulated
