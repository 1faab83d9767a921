#pragma once
// The repeated readings of one attempt, with the scale read back before, between and after them.

#include <string>
#include <vector>

#include "server/application/workbench.h"

namespace driftwise::application {

struct Sampling {
  std::vector<Reading>
      readings;  // as they came: readbacks (device = the controller) and interferometers
  std::vector<double> q_mm;  // mean of the readbacks, per axis
  std::vector<ChannelValue>
      means;  // of every interferometer channel, in order of first appearance; kMissing left out
  std::vector<ChannelValue>
      spreads_nm;  // per length channel: x_std_nm, sample standard deviation of the readings
  double spread_nm = kMissing;  // the largest of them
  Stamp measured;               // middle between the first and the last interferometer reading
};

// Errors: those of the devices (BEAM_LOST among them); aborted, cancelled. Readings are shown to
// the recorder as they come.
Awaitable<Result<Sampling>> take_readings(RunScope& scope, int count);

}  // namespace driftwise::application
