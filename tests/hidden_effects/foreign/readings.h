#pragma once

#include <Eigen/Core>
#include <string>

#include "tests/hidden_effects/foreign/campaign.h"
#include "tests/hidden_effects/foreign/random.h"

namespace driftwise::foreign {

// A catalogue cause as it was planted: `stream` is the state of the random stream before its
// parameters were drawn, `effect` is without noise (rows x coordinates, mm or arcsec).
struct Planted {
  std::string cause;
  Random stream;
  double amplitude = 1.0;
  Eigen::MatrixXd effect;
};

// Strength of an effect, and the part of it that the file's readings carry (strength.h).
struct Carried {
  double chi2 = 0.0;
  double in_readings = 0.0;
  double in_smoothed_readings = 0.0;
  // Free amplitudes: pose coordinates on which the cause acts.
  int columns = 0;
};

// Columns of the true cause with its true parameters, worked out from the file: temperatures and
// tilts as they were read, moves from row to row, activity as held from row to row.
//
// given: thermometer readings that the baseline has (rows x thermometers). tilt_read: rx, ry, rz as
// written, or empty. Throws std::runtime_error where the campaign cannot show the cause.
Carried carried_by_readings(const Campaign& campaign, const Planted& planted,
                            const Eigen::MatrixXd& given, const Eigen::MatrixXd& tilt_read);

}  // namespace driftwise::foreign
