#include "drivers/simulated/plant/hidden/hidden_mechanism.h"

#include "drivers/simulated/plant/hidden/hidden_contact.h"
#include "drivers/simulated/plant/hidden/hidden_optics.h"
#include "drivers/simulated/plant/hidden/hidden_thermal.h"

namespace driftwise::simulated {
namespace {

// One overload per effect that acts by itself.
struct Maker {
  std::string name;
  std::uint64_t seed;
  double step_s, start_degc;
  std::span<const double> wavelength_nm;
  PlacedMechanism out{};

  template <class Mechanism, class... Parameters>
  void on_stage(int axis, const Parameters&... parameters) {
    out = {name, HiddenPlace::stage_nm, axis, std::make_unique<Mechanism>(parameters...)};
  }
  template <class Mechanism, class... Parameters>
  void on_beam(int beam, const Parameters&... parameters) {
    out = {name, HiddenPlace::beam_nm, beam, std::make_unique<Mechanism>(parameters...)};
  }
  double wave_nm(int beam) const { return wavelength_nm[static_cast<std::size_t>(beam)]; }
  Random random() const { return {seed, "hidden." + name}; }

  void operator()(const HiddenSlab& e) { on_stage<SlabMechanism>(e.axis, e, start_degc); }
  void operator()(const HiddenMotorHeat& e) { on_stage<MotorHeatMechanism>(e.axis, e); }
  void operator()(const HiddenFriction& e) { on_stage<FrictionMechanism>(e.axis, e); }
  void operator()(const HiddenViscoelastic& e) { on_stage<ViscoelasticMechanism>(e.axis, e); }
  void operator()(const HiddenScaleSignals& e) { on_stage<ScaleSignalsMechanism>(e.axis, e); }
  void operator()(const HiddenSlip& e) { on_stage<SlipMechanism>(e.axis, e); }
  void operator()(const HiddenParticle& e) { on_stage<ParticleMechanism>(e.axis, e); }
  void operator()(const HiddenBallContact& e) { on_stage<BallContactMechanism>(e.axis, e); }
  void operator()(const HiddenFringeMixing& e) {
    on_beam<FringeMixingMechanism>(e.beam, e, wave_nm(e.beam));
  }
  void operator()(const HiddenLaserDrift& e) { on_beam<LaserDriftMechanism>(e.beam, e); }
  void operator()(const HiddenLostFringe& e) {
    on_beam<LostFringeMechanism>(e.beam, e, wave_nm(e.beam));
  }
  void operator()(const HiddenLevelControl& e) {
    on_beam<LevelControlMechanism>(e.beam, e, random());
  }
  void operator()(const HiddenGlitches& e) { on_beam<GlitchMechanism>(e.beam, e, random()); }
  void operator()(const HiddenFan& e) { on_beam<FanMechanism>(e.beam, e, step_s, random()); }
  void operator()(const HiddenDeadPath&) {}
  void operator()(const HiddenWeatherFront&) {}
  void operator()(const HiddenBeamPlace&) {}
  void operator()(const HiddenThermometer&) {}
};

}  // namespace

std::vector<PlacedMechanism> hidden_mechanisms(std::span<const Hidden> hidden, std::uint64_t seed,
                                               double step_s, double start_degc,
                                               std::span<const double> wavelength_nm) {
  std::vector<PlacedMechanism> all;
  for (const Hidden& one : hidden) {
    Maker maker{one.name, seed, step_s, start_degc, wavelength_nm};
    std::visit(maker, one.effect);
    if (maker.out.mechanism) all.push_back(std::move(maker.out));
  }
  return all;
}

}  // namespace driftwise::simulated
