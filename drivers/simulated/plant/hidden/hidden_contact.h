#pragma once
// Hidden contacts: friction beside a structure that gives, glue that creeps, a particle on a guide,
// a ball under load, a joint that slips.

#include "drivers/simulated/plant/hidden/hidden_mechanism.h"

namespace driftwise::simulated {

// Iwan (1966): spring-sliders in parallel, here four, that break loose one after the other at a
// quarter to twice the presliding distance. Their force bends the structure between scale and
// stage. Fully reversed the stage is 2 friction / stiffness away: what looks like a play.
class FrictionMechanism final : public HiddenMechanism {
 public:
  explicit FrictionMechanism(const HiddenFriction& friction) : friction_(friction) {}
  void step(const GridInstant& now) override;
  double memory() const override;
  double value_nm(const HiddenContext&, double memory) const override { return memory; }

 private:
  static constexpr std::size_t kSliders = 4;
  static constexpr std::array<double, kSliders> kBreak{0.25, 0.5, 1.0, 2.0};  // of presliding

  HiddenFriction friction_;
  bool started_ = false;
  double last_mm_ = 0;
  std::array<double, kSliders> drawn_mm_{};
};

// Three Kelvin-Voigt elements in a row with what they hang on: after a move a share of it is still
// to come, and comes with three times (generalised viscoelastic solid; Findley, Lai & Onaran 1976).
class ViscoelasticMechanism final : public HiddenMechanism {
 public:
  explicit ViscoelasticMechanism(const HiddenViscoelastic& glue) : glue_(glue) {}
  void step(const GridInstant& now) override;
  double memory() const override;
  double value_nm(const HiddenContext&, double memory) const override { return memory; }

 private:
  HiddenViscoelastic glue_;
  bool started_ = false;
  double last_mm_ = 0;
  std::array<double, 3> late_mm_{};
};

class ParticleMechanism final : public HiddenMechanism {
 public:
  explicit ParticleMechanism(const HiddenParticle& particle) : particle_(particle) {}
  double value_nm(const HiddenContext& at, double memory) const override;

 private:
  HiddenParticle particle_;
};

// Approach of a ball and a flat of the same material, Hertz 1882 (Johnson, Contact Mechanics,
// section 4.2), Poisson's ratio 0.3.
class BallContactMechanism final : public HiddenMechanism {
 public:
  explicit BallContactMechanism(const HiddenBallContact& ball) : ball_(ball) {}
  double value_nm(const HiddenContext& at, double memory) const override;

 private:
  HiddenBallContact ball_;
};

class SlipMechanism final : public HiddenMechanism {
 public:
  explicit SlipMechanism(const HiddenSlip& slip) : slip_(slip) {}
  double value_nm(const HiddenContext& at, double) const override {
    return at.time_s >= 3600 * slip_.at_h ? slip_.nm : 0;
  }

 private:
  HiddenSlip slip_;
};

}  // namespace driftwise::simulated
