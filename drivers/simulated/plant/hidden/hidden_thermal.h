#pragma once
// Hidden heat: a plate that warms through its thickness, a drive that warms what carries it.

#include <array>

#include "drivers/simulated/plant/hidden/hidden_mechanism.h"

namespace driftwise::simulated {

// One-dimensional conduction through eight slices, a film to the part on one face, none on the
// other (Incropera & DeWitt, chapter 5): not a single time constant, but a series of them.
class SlabMechanism final : public HiddenMechanism {
 public:
  SlabMechanism(const HiddenSlab& slab, double start_degc);
  void step(const GridInstant& now) override;
  double memory() const override { return nm_; }
  double value_nm(const HiddenContext&, double memory) const override { return memory; }

 private:
  static constexpr std::size_t kSlices = 8;
  double length_nm() const;
  double sag_nm() const;

  HiddenSlab slab_;
  double slice_m_, start_degc_;
  std::array<double, kSlices> degc_{};
  double nm_ = 0;
};

// Two masses in a row: the drive, where the heat of travel appears, and its carrier, whose length
// counts; the carrier loses heat to a part of the plant.
class MotorHeatMechanism final : public HiddenMechanism {
 public:
  explicit MotorHeatMechanism(const HiddenMotorHeat& heat) : heat_(heat) {}
  void step(const GridInstant& now) override;
  double memory() const override;
  double value_nm(const HiddenContext&, double memory) const override { return memory; }

 private:
  HiddenMotorHeat heat_;
  bool started_ = false;
  double last_mm_ = 0, drive_k_ = 0, carrier_k_ = 0;  // above the part
};

}  // namespace driftwise::simulated
