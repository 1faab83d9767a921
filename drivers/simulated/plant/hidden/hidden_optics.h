#pragma once
// Hidden errors of measuring light: gratings and fringes that are not ideal, a laser that is not
// locked, air that is stirred, counts that are lost.

#include "drivers/simulated/plant/hidden/hidden_mechanism.h"
#include "drivers/simulated/plant/numbers/random.h"

namespace driftwise::simulated {

// The reading head's two signals are cos and sin of the phase, distorted; its arctangent is what
// the scale shows (Heydemann 1981). Acts on the stage the other way, since the servo follows.
class ScaleSignalsMechanism final : public HiddenMechanism {
 public:
  explicit ScaleSignalsMechanism(const HiddenScaleSignals& signals) : signals_(signals) {}
  double value_nm(const HiddenContext& at, double memory) const override;

 private:
  HiddenScaleSignals signals_;
};

// Phasors: measuring light, a ghost of it that goes round at another rate, light of the wrong
// polarisation that turns the other way (Quenelle 1983; Bobroff 1993). Period half a wave.
class FringeMixingMechanism final : public HiddenMechanism {
 public:
  FringeMixingMechanism(const HiddenFringeMixing& mixing, double wavelength_nm)
      : mixing_(mixing), wavelength_nm_(wavelength_nm) {}
  double value_nm(const HiddenContext& at, double memory) const override;

 private:
  HiddenFringeMixing mixing_;
  double wavelength_nm_;
};

// The whole path, dead path and all, is counted in waves that get longer.
class LaserDriftMechanism final : public HiddenMechanism {
 public:
  explicit LaserDriftMechanism(const HiddenLaserDrift& drift) : drift_(drift) {}
  double value_nm(const HiddenContext& at, double memory) const override;

 private:
  HiddenLaserDrift drift_;
};

class LostFringeMechanism final : public HiddenMechanism {
 public:
  LostFringeMechanism(const HiddenLostFringe& lost, double wavelength_nm)
      : lost_(lost), wavelength_nm_(wavelength_nm) {}
  double value_nm(const HiddenContext& at, double) const override {
    return at.time_s >= 3600 * lost_.at_h ? lost_.half_waves * wavelength_nm_ / 2 : 0;
  }

 private:
  HiddenLostFringe lost_;
  double wavelength_nm_;
};

// Poisson arrivals, drawn one ahead; each lasts a while and has its own side.
class GlitchMechanism final : public HiddenMechanism {
 public:
  GlitchMechanism(const HiddenGlitches& glitches, Random random)
      : glitches_(glitches), random_(random) {}
  void step(const GridInstant& now) override;
  double memory() const override { return nm_; }
  double value_nm(const HiddenContext&, double memory) const override { return memory; }

 private:
  HiddenGlitches glitches_;
  Random random_;
  bool drawn_ = false;
  double start_s_ = 0, size_nm_ = 0, nm_ = 0;
};

// Warmer and cooler air passes the beam once the fan runs.
class FanMechanism final : public HiddenMechanism {
 public:
  FanMechanism(const HiddenFan& fan, double step_s, Random random)
      : fan_(fan), eddies_k_(fan.eddy_k, fan.eddy_s, step_s, random) {}
  void step(const GridInstant&) override { eddies_k_.step(); }
  double memory() const override { return eddies_k_.value(); }
  double value_nm(const HiddenContext& at, double memory) const override;

 private:
  HiddenFan fan_;
  Wander eddies_k_;
};

// A table that leaks down and is filled up again between two levels, seen through its inertia.
class LevelControlMechanism final : public HiddenMechanism {
 public:
  LevelControlMechanism(const HiddenLevelControl& control, Random random);
  void step(const GridInstant& now) override;
  double memory() const override { return seen_ * control_.nm; }
  double value_nm(const HiddenContext&, double memory) const override { return memory; }

 private:
  HiddenLevelControl control_;
  bool fills_ = false;
  double level_ = 0, seen_ = 0;  // -1 .. 1
};

}  // namespace driftwise::simulated
