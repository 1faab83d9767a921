#pragma once
// Whether a finding about an instrument can be one instrument's: every output of the robot sees the
// same instrument, and its parameter must be possible. Pure.
//
// With S the slopes of the outputs over the pose axes (server/simulation/motor_slopes.h), an error
// e of an axis is seen in output o as c_o = -S_o e. What is accepted is the e of all outputs
// together (least squares); each output by itself says -c_o / S_o. Where the rest c_o + S_o e is
// beyond what the output's own evidence allows (its 2 ln L: standard error |c_o| / sqrt(2 ln L),
// chi-squared at 0.1 %) and a quarter or more of the whole, the outputs speak of different things.
//
// Largest possible values, by what a term is (generous: they tell the impossible, not the
// unlikely):
//   tilt                 lever arm of a beam             1000 mm    larger than any machine of a
//   cell tilt x length        angle of a beam                 3600 arcsec  the beam misses its
//   receiver far
//                                                        below: 1 m away it is 5 mm off at 1000
//                                                        arcsec
//   drift                of a zero                       10 000 nm/h  1 m of steel at 1 K/h: 12
//   um/h drift x length       of a scale                      10 ppm/h   air: 0.93 ppm/K, 0.27
//   ppm/hPa air index            dead path                       5000 mm air, pressure, humidity a
//   zero            5000 nm per unit: that dead path air, pressure, humidity x length   a scale 2
//   ppm per unit: twice the air's own sin, cos of a length interpolation                   a
//   quarter of its period

#include <Eigen/Core>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/diagnosis/answer/finding.h"

namespace driftwise::application {

struct InstrumentClaim {
  std::vector<Channel> outputs;   // of the simulation
  std::vector<std::string> axes;  // that the correction is for: "x"
  Eigen::MatrixXd slopes;         // outputs x axes, mm per mm
  Eigen::MatrixXd seen_mm;        // outputs x terms of the finding, mm of q per unit of a term
  Eigen::MatrixXd error_mm;       // axes x terms: what would be corrected
};

// number: of the finding, from 1. Errors, failed_precondition: IMPOSSIBLE_PARAMETER, with value and
// limit; OUTPUTS_DISAGREE, with what each output says.
Result<void> check_instrument(int number, const diagnosis::Finding& finding,
                              const InstrumentClaim& claim, const Dataset& data);

}  // namespace driftwise::application
