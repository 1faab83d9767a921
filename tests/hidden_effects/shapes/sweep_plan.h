#pragma once
// What a sweep goes through, where its outcomes are kept, and what they count up to.

#include <iosfwd>
#include <string>
#include <vector>

#include "tests/hidden_effects/shapes/hidden_case.h"

namespace driftwise::hidden {

struct SweepPlan {
  std::string kind = "single", robot = "linear", cause{};
  std::vector<double> chi2 = {75}, autocorrelation = {0.3};
  int sets = 20;
  std::uint64_t seed = 1;
  bool two_times = false;
  double hold_nm = 0;  // of the World; not 0: the noise is in the pose
};

struct SweepCase {
  std::string key, group;
  World world;
  std::vector<Hidden> hidden;
  std::uint64_t seed = 0;
};
std::vector<SweepCase> cases_of(const SweepPlan& plan);

struct SweepResult {
  std::string key, group;
  Outcome outcome;
};
std::string line_of(const SweepResult& result);  // tab-separated, ends in a line feed
std::vector<SweepResult> read_results(const std::string& path);  // none: empty

struct Rate {
  int hits = 0, sets = 0;
  double low() const;  // Clopper-Pearson, 95 %
  double high() const;
};

// Counts per group with Clopper-Pearson intervals, how often the intervals of each cause's
// parameter cover, and the detection curve as a table of docs/diagnosis.md. Result: promises that
// an interval excludes.
std::vector<std::string> print_report(const std::vector<SweepResult>& results, std::ostream& out);

}  // namespace driftwise::hidden
