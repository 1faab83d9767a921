#pragma once
// A return to zero against the last good one. Pure.
//
// Between two returns the pose of the zero may drift as fast as the start check allows, and stray
// by less than a fringe. A larger difference is a length that jumped, a fringe that was lost, a
// robot that slipped: the points in between rest on no known zero.

#include <optional>
#include <string>
#include <vector>

#include "server/core/data/reading.h"
#include "server/core/description/cell_description.h"

namespace driftwise::plausibility {

struct Closure {
  CellTime at;
  std::vector<double> lengths_nm;     // since the datum's zero, per length of the cell; kMissing
  std::vector<double> angles_arcsec;  // likewise
  std::optional<double> force_n;
};

struct ClosureVerdict {
  bool good = true;
  std::string sentence;  // of a bad one: which, how far, the limit
};

class ClosureJudge {
 public:
  explicit ClosureJudge(const CellDescription& cell) : cell_(cell) {}  // outlives this

  // The zero itself, with which every datum begins.
  void begin(CellTime at, std::optional<double> force_n);
  // A good closure is what the next one is compared with.
  ClosureVerdict judge(const Closure& closure);

  // Of the last good closure, or the datum's zero.
  CellTime last_good() const { return last_.at; }

 private:
  const CellDescription& cell_;
  Closure last_;
};

}  // namespace driftwise::plausibility
