#pragma once
// One data set: hide, diagnose, judge.

#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "tests/hidden_effects/shapes/hidden_world.h"

namespace driftwise::hidden {

struct Outcome {
  bool exact = false;         // every hidden cause named, nothing else
  bool exact_or_set = false;  // ... or in the reported set of what was named instead
  bool subject = false;       // exact, and about the right subject
  int false_names = 0;        // names that are neither hidden nor have the hidden one in their set
  std::string named;          // "thermal_lag t07; creep q1"
  std::string verdict;
  std::string note;         // what came nearest where nothing was named
  double identifiable = 0;  // 2 ln L between the truth and the nearest other cause; single causes
  int covers = -1;          // the interval of the searched parameter: -1 none, 0, 1
  double width_over_bound = 0;         // of that interval, over the Cramer-Rao bound's
  double gain = 0, gain_of_truth = 0;  // held-out U90, all outputs together: nm gained
  double seconds = 0;
};

// nulls: of the diagnosis; with_truth: identifiability and bounds too, which take as long. Throws
// std::runtime_error when the diagnosis fails.
Outcome judged(const World& world, const std::vector<Hidden>& hidden, std::uint64_t seed,
               int nulls = 199, bool with_truth = true);

struct Truth {
  double identifiable = 0;
  std::optional<double> bound_sd;  // Cramer-Rao, of the searched parameter
};
// Computed with the noise's own covariance and the truth known.
Truth truth_of(const HiddenData& made);

}  // namespace driftwise::hidden
