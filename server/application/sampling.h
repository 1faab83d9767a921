#pragma once
// The repeated readings of one attempt, with the scale read back before, between and after them.

#include <string>
#include <vector>

#include "server/application/workbench.h"

namespace driftwise::application {

struct Sampling {
  // As they came: readbacks (device = the controller), interferometers and autocollimators.
  std::vector<Reading> readings;
  std::vector<double> q_mm;  // mean of the readbacks, per axis
  std::vector<ChannelValue>
      raw;  // of every channel of an instrument, in order of first appearance; kMissing left out
  std::vector<ChannelValue> means;  // the same after the correction stage: pose, then the rest
  std::vector<ChannelValue>
      spreads_nm;  // per length channel: x_std_nm, sample standard deviation of the readings
  double spread_nm = kMissing;  // the largest of them
  Stamp measured;               // middle between the first and the last round of instruments
};

// Errors: those of the devices (BEAM_LOST among them); aborted, cancelled. Readings are shown to
// the recorder as they come.
Awaitable<Result<Sampling>> take_readings(RunScope& scope, int count);

}  // namespace driftwise::application
