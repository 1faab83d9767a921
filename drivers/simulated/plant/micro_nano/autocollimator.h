#pragma once
// An autocollimator's reading of one angle, and its slow drift.

#include <array>
#include <cstdint>

#include "drivers/simulated/plant/micro_nano/micro_nano_machine.h"
#include "drivers/simulated/plant/numbers/random.h"

namespace driftwise::simulated {

// Drift of one channel (two per device, counted through all devices), arcsec: a smooth function of
// time, standard deviation and period as `parameters` say.
double collimator_drift_arcsec(const CollimatorParameters& parameters, std::uint64_t seed,
                               int channel, double time_s);

// Readings of an angle: {angle, the device's other angle}, rad; roll about the beam mixes
// them.
double collimator_arcsec(const CollimatorParameters& parameters, const Machine::Collimator& device,
                         const std::array<double, 2>& true_rad, double offset_arcsec,
                         double drift_arcsec, double average_s, Random& noise);

}  // namespace driftwise::simulated
