#pragma once
// Runs of a cell in memory that is disturbed: bunches of bad readings, a laser that is away for a
// while and takes its datum with it. Each run has a restlessness of its own. Counts how often
// the end of a run lies in the band that the daemon stated at 10, 50 and 90 % of it.

#include <array>
#include <string>
#include <vector>

namespace driftwise::tests {

struct Restlessness {
  std::string name;
  double bursts_per_h = 0, burst_s = 0, bad_share = 0;  // of bad groups within a burst
  double absences_per_h = 0, absence_s = 0;             // of the laser
  double between_runs = 0;                              // sd of the logarithm of all rates
  int lines = 0, rows_of_line = 0;
};
// Populations that the estimator was developed on, and others that it is counted on.
Restlessness development_population();
std::vector<Restlessness> development_populations();  // that one first
std::vector<Restlessness> counted_populations();

struct BandCount {
  int asked = 0, inside = 0, early = 0, late = 0;  // early: the run ended before the band
  double width_share = 0;                          // mean of the band's width over what was ahead
  double share() const { return static_cast<double>(inside) / asked; }
};
constexpr std::array kAskedAt{0.1, 0.5, 0.9};
struct TimeToEnd {
  std::array<BandCount, kAskedAt.size()> at;
  double rereads_per_row = 0, longest_run_h = 0, shortest_run_h = 1e9;
  int runs = 0;
};

// A cell of its own for each seed: `before` runs of history, then `runs` that count.
void count_cell(const Restlessness& population, unsigned seed, int before, int runs,
                TimeToEnd& count);

}  // namespace driftwise::tests
