#pragma once
// Many simulated campaigns, counted.

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "tests/statistics/coverage_count.h"
#include "tests/statistics/served_case.h"

namespace driftwise::statistics {

// Targets by how long after the zero they were asked for.
struct CoverageByLead {
  double from_h = 0, to_h = 0;  // from_h is inside, to_h is not
  CoverageCount inside;
  double ratios = 0, squares = 0;  // sums of |error| / u and of its square
};
std::vector<CoverageByLead> lead_classes();

struct CoverageOfOutput {
  std::string channel;
  CoverageCount inside;                                              // targets inside the domain
  std::int64_t outside = 0;                                          // left out
  double squares = 0;                                                // sum of (error / u)^2
  double error_nm2 = 0;                                              // sum of error^2
  std::array<double, compensation::kUncertaintySources> line_nm2{};  // sums of the budget's lines
  std::vector<CoverageByLead> by_lead = lead_classes();
  double rms_ratio() const;  // of error to standard uncertainty: 1 when the budget is right
};

// One entry per motor coordinate, and "all" of them at the end. simulate(seed): one campaign.
// report(done): called after each, from one thread at a time.
std::vector<CoverageOfOutput> run_coverage(
    const std::function<SimulatedCase(std::uint64_t seed)>& simulate, std::uint64_t first_seed,
    int campaigns, int threads,
    const std::function<void(int done, const std::vector<CoverageOfOutput>& so_far)>& report);

// The table as docs/uncertainty.md has it.
std::string coverage_table(const std::vector<CoverageOfOutput>& outputs);

}  // namespace driftwise::statistics
