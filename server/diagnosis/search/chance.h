#pragma once
// How often chance does as well, after the search over parameters and causes: from series simulated
// with the fitted noise and pushed through the same scan, extended into the tail by its known
// shape.

#include <vector>

namespace driftwise::diagnosis {

// The largest evidence over all causes, in 2 ln of a ratio of marginal likelihoods. A ratio has the
// mean 1 where nothing is hidden, so its tail falls like exp(-x / 2) or faster: the largest of many
// has Gumbel's distribution with scale 2. Its location is fitted to the nulls by maximum
// likelihood, and so is a stretch of the scale where the noise is not known exactly, held to 1 as
// by a hundred nulls (it is 1 in theory; one estimated from a few nulls is a poor guide).
class EvidenceTail {
 public:
  EvidenceTail() = default;
  explicit EvidenceTail(std::vector<double> null_maxima);
  double p(double evidence) const;  // of one look at all causes
  double location() const { return location_; }

 private:
  double location_ = 0, scale_ = 2;
};

}  // namespace driftwise::diagnosis
