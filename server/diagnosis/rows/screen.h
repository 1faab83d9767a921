#pragma once
// What is wrong with the data themselves, found before anything becomes physics.

#include <functional>
#include <optional>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

enum class SensorFault : std::uint8_t { frozen, jumped, spiked, swapped };

struct FaultySensor {
  SensorFault fault = SensorFault::frozen;
  std::string channel, other;     // other: what it was swapped with
  std::vector<std::size_t> rows;  // frozen, spiked: the wrong ones; jumped, swapped: from here on
  double size = 0;                // of a jump, in the channel's unit
  bool mended = true;             // false: the readings are as they were
  // Chance that readings which are right look so, for all rows and thermometers looked at.
  double p = 1;
  bool named = true;         // false: told only, it may be real
  bool is_followed = false;  // a jump that the outputs follow: told only, it is real
  // At the row of a jump other thermometers change beyond their noise; false too where there are
  // none.
  bool others_change = false;
};

// A level of every output from one row of the dataset on, free beside the baseline.
struct FreeLevel {
  std::size_t row = 0, unread = 0;  // unread: rows to either side that say nothing
  bool is_free = false;             // false: no level, but the same rows are unread
};
// 2 ln L of the outputs by the baseline with these readings, up to a constant.
using OutputsLikelihood = std::function<double(const Dataset& dataset, const FreeLevel& level)>;

// two_ln_likelihood() of what `lay_out` makes of the readings: laid out once for as long as they
// stay the same, whatever the level. Nothing laid out: -INFINITY.
OutputsLikelihood likelihood_of(
    std::function<std::optional<Problem>(const Dataset& dataset)> lay_out);

// Structure temperatures only, judged by themselves and each other, not by what they explain:
// frozen: the same number to the last digit for a tenth of the rows or more, and ten times longer
//   than anywhere else; spiked: one to ten values off the neighbours on both sides, which agree;
//   jumped: a change from one row to the next a dozen times its usual size, that stays, and that
//   most others do not make; swapped: two sensors that take one another's place in one row.
// Single wrong values and those of a frozen stretch are blanked. A jump or an exchange is mended
// only on evidence: a part can really warm. two_ln_likelihood says how well the baseline describes
// the outputs with the readings as given to it: mended they must do better by 2 ln L of 25.
// A jump without a ramp that the outputs neither speak for nor against is left as it was measured,
// and named where there are other thermometers and none of them changes at that row beyond its
// noise: else the room may have done it, and it is told only. A jump of four usual changes, or with
// a ramp after it, is named where the outputs speak for it: no free step of theirs explains more
// beyond chance, no lag as much, and no knock of the robot at that row is likelier than alpha.
// One that the outputs follow is none: they
// lose more without it than chance takes in one of a hundred, and would lose with the same jump at
// any of nineteen other rows; or they follow it with a lag. Outputs that step at that row by
// something else are no such witness. outputs: their number.
// A fault is named where its p is at most alpha. Frozen: a run of equal readings as long as that,
// by how often the other readings repeat. Spiked, jumped: as large a change under Student's law
// with the degrees of freedom that the sensor's other changes have (heavy tails: a room with
// doors); times what the outputs say, exp(-gain / 2) of 2 ln L: a ratio of likelihoods has the
// mean 1 where the readings are right. Swapped: by the outputs alone.
// The largest jumps of a thermometer are looked at, sixteen of them at most, and as many suspects.
// tick: called between thermometers and rows; false ends it, and what was found is of no use.
std::vector<FaultySensor> mend_sensors(Dataset& dataset, std::size_t outputs, double alpha,
                                       const OutputsLikelihood& two_ln_likelihood,
                                       const std::function<bool()>& tick = {});

// Of the outputs by the baseline, least squares over the rows that learn, with noise of first order
// (correlated from row to row and between the outputs), up to a constant.
double two_ln_likelihood(const Problem& problem, const FreeLevel& level = {});

struct OutlierRow {
  std::size_t row = 0;  // of the dataset
  std::string output;
  double p = 1;  // of all wrong rows of the look together
};

// Isolated wrong rows, of those that learn and those that judge: one, or up to four in a row that
// are off to the same side, far off the neighbours in time on both sides, which agree with one
// another. Nothing when there are so many that they are no exceptions (5 %); not where those
// measured beside it in position are half as far off: then the place is wrong. Nothing where as
// many rows as far off are likelier than alpha under Student's law with the degrees of freedom that
// the other rows have.
std::vector<OutlierRow> outlier_rows(const Problem& problem, double alpha);

// Rows that are too far off for the noise, tails and all, in what is left, whitened: a few gross
// errors of a size of their own beside a Student law, against a Student law alone, whose degrees of
// freedom all outputs share. The growth of 2 ln L is compared with that of rows drawn from the
// Student law alone, and asked for 2 ln(outputs / alpha) at least. Nothing where
// neighbours in time or place share it, nor where the search works on averages of rows.
std::vector<OutlierRow> gross_errors(const Problem& problem, const Ground& ground, double alpha);

struct NoiseChange {
  std::size_t output = 0;
  Eigen::Index block = 0;  // from here on
  double ratio = 1;        // of standard deviations, after over before
  double gain = 0;         // of 2 ln L
  double together = 0;     // of all outputs whose spread changes there
};

// A change of spread at one instant in what is left, whitened: of each output for itself, or of all
// at one instant where that explains more. Nothing below a gain of 30, and 10 for each further
// output of a sum: the largest over all instants reaches 30 by chance less than once in ten
// thousand.
std::vector<NoiseChange> noise_changes(const Ground& ground);

}  // namespace driftwise::diagnosis
