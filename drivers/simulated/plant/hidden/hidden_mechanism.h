#pragma once
// A mechanism that a plant hides: what it remembers is stepped on the plant's grid, what it adds
// follows from that memory and from where the plant is at the instant asked for.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/simulated/plant/hidden_parameters.h"
#include "drivers/simulated/plant/thermal/thermal_network.h"

namespace driftwise::simulated {

inline constexpr std::size_t kMaxHidden = 8;

// What a grid step offers: the state at its end.
struct GridInstant {
  double time_s = 0, step_s = 0;
  const NodeTemperatures* degc = nullptr;
  std::span<const double> scale_mm;  // per axis
};

// Where the plant is at the instant asked for.
struct HiddenContext {
  double time_s = 0;
  double stage_mm = 0;  // of the mechanism's axis
  double path_mm = 0;   // head to mirror, of the mechanism's beam
  double force_n = 0;   // that pulls
};

enum class HiddenPlace {
  stage_nm,  // the stage against its scale: the robot is really there
  beam_nm    // what an interferometer shows
};

class HiddenMechanism {
 public:
  virtual ~HiddenMechanism() = default;
  virtual void step(const GridInstant& /*now*/) {}
  virtual double memory() const { return 0; }  // kept with every step, interpolated in between
  // nm at its place. memory: that of the instant.
  virtual double value_nm(const HiddenContext& at, double memory) const = 0;
};

// Those of the effects that act by themselves; the others change parts of the plant
// (hidden_changes.h) and are nullptr here.
struct PlacedMechanism {
  std::string name{};
  HiddenPlace place = HiddenPlace::stage_nm;
  int index = 0;
  std::unique_ptr<HiddenMechanism> mechanism{};
};

// start_degc: of everything, when the plant's story is warmed up. wavelength_nm: per beam.
std::vector<PlacedMechanism> hidden_mechanisms(std::span<const Hidden> hidden, std::uint64_t seed,
                                               double step_s, double start_degc,
                                               std::span<const double> wavelength_nm);

}  // namespace driftwise::simulated
