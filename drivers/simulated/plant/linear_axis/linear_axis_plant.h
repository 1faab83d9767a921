#pragma once
// The linear axis of the published study, case A: a flexure parallelogram with a voice coil and a 5
// nm scale, one laser interferometer on a stabilised support, ten pt1000, a room with air
// conditioning. Time, noise and looking back: cell_plant.h.

#include "drivers/simulated/plant/cell/cell_plant.h"
#include "drivers/simulated/plant/linear_axis/linear_axis_parameters.h"
#include "drivers/simulated/plant/truth.h"

namespace driftwise::simulated {

class LinearAxisPlant final : public CellPlant {
 public:
  LinearAxisPlant(LinearAxisParameters parameters, std::uint64_t seed, TimeNs epoch);

  Truth truth(TimeNs at);
  std::vector<std::string> truth_columns() const override;
  std::vector<double> truth_values(TimeNs at) override;
  const LinearAxisParameters& parameters() const { return parameters_; }

 protected:
  Beam beam(int index, double time_s) const override;

 private:
  struct Instant;
  Instant instant(double time_s) const;

  const LinearAxisParameters& parameters_;  // the base's
};

}  // namespace driftwise::simulated
