#pragma once
// The repeated readings of one attempt, with the scale read back before, between and after them.

#include <string>
#include <vector>

#include "server/application/motion/workbench.h"

namespace driftwise::application {

struct RotationSpread {
  std::string channel;
  double arcsec = 0;    // sample standard deviation of the readings
  double u_arcsec = 0;  // that its instrument declares
};

struct Sampling {
  // As they came: readbacks (device = the controller), interferometers and autocollimators.
  std::vector<Reading> readings;
  std::vector<double> q_mm;  // mean of the readbacks, per axis
  std::vector<ChannelValue>
      raw;  // of every channel of an instrument, in order of first appearance; kMissing left out
  std::vector<ChannelValue> means;  // the same after the correction stage: pose, then the rest
  std::vector<ChannelValue>
      spreads_nm;  // per length channel: x_std_nm, sample standard deviation of the readings
  double spread_nm = kMissing;            // the largest of them
  std::vector<RotationSpread> rotations;  // per angle channel that was read
  // Of the scale over the whole reading, the axis that is worst.
  double off_nm = 0;           // from where it was sent, any readback
  double peak_to_peak_nm = 0;  // of the readbacks
  Stamp measured;              // middle between the first and the last round of instruments
};

// commanded_mm: where the axes were sent; empty: off_nm stays 0. Errors: those of the devices
// (BEAM_LOST among them); IMPLAUSIBLE, a value or the pose that nothing may use: what was read is
// stored all the same; aborted, cancelled. Readings are shown to the recorder as they come.
Awaitable<Result<Sampling>> take_readings(RunScope& scope, int count,
                                          std::vector<double> commanded_mm = {});

// Asks every instrument once and judges what it says, as for a point; nothing is kept but what was
// rejected. Errors as take_readings.
Awaitable<Result<void>> look_at_pose(RunScope& scope);

}  // namespace driftwise::application
