#pragma once
// How often the truth lay within a stated uncertainty, and how well that rate is known.

#include <cstdint>
#include <vector>

namespace driftwise::statistics {

struct Interval {
  double low = 0, high = 1;
};

// Clopper-Pearson: the rates for which hits or fewer, and hits or more, of so many independent
// tries are each at least (1 - confidence) / 2 likely. Real numbers of tries are allowed (below).
Interval clopper_pearson(double hits, double tries, double confidence = 0.95);

class CoverageCount {
 public:
  // One campaign's targets: their errors are not independent of one another.
  void add_campaign(std::int64_t hits, std::int64_t targets);

  std::int64_t campaigns() const { return static_cast<std::int64_t>(campaigns_.size()); }
  std::int64_t hits() const { return hits_; }
  std::int64_t targets() const { return targets_; }
  double rate() const;

  // As if every target were independent: too narrow.
  Interval per_target() const {
    return clopper_pearson(static_cast<double>(hits_), static_cast<double>(targets_));
  }
  // Campaigns are the independent units: Clopper-Pearson at the effective number of targets, by the
  // variance of the campaigns' rates (Korn and Graubard 1998, with their t correction).
  Interval clustered() const;
  double effective_targets() const;
  // Middle 95 % of the rates of so many collections of as many campaigns, each drawn from these
  // with replacement (Efron's percentiles). The same campaigns give the same interval.
  Interval resampled(int collections = 4000) const;

 private:
  struct Campaign {
    double hits = 0, targets = 0;
  };
  std::vector<Campaign> campaigns_;
  std::int64_t hits_ = 0, targets_ = 0;
};

}  // namespace driftwise::statistics
