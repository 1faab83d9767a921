#pragma once
// Heat capacities joined by conductances, stepped exactly.
//
//   C_i dT_i/dt = sum_j G_ij (T_j - T_i) + G_i,room (T_room - T_i) + P_i
//
// With the room and the powers held over a step the solution is a matrix exponential, computed
// once: no step is too long for stability and no step error builds up. One step costs n^2
// multiplications.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

inline constexpr std::size_t kMaxNodes = 40;
using NodeTemperatures = std::array<double, kMaxNodes>;  // degC; unused nodes stay as they are

class ThermalNetwork {
 public:
  // Extra conductances (the Peltier element's own) come as further links. All nodes start at
  // start_degc.
  ThermalNetwork(std::span<const PartParameters> parts, std::span<const LinkParameters> links,
                 double step_s, double start_degc);

  // power_w: one per node, into the node.
  void step(double room_degc, std::span<const double, kMaxNodes> power_w);

  const NodeTemperatures& degc() const { return degc_; }
  std::size_t size() const { return size_; }

 private:
  std::size_t size_;
  // Columns of [exp(A dt) | response to 1 K of room | response to 1 W on node 0, 1, ..], each
  // kMaxNodes long.
  std::vector<double> columns_;
  NodeTemperatures degc_{};
};

}  // namespace driftwise::simulated
