#pragma once
// A return to zero against the last good one from the same side, with its budget. Pure.
//
// Between two returns the pose of the zero may drift as fast as the start check allows, and stray
// by less than a fringe. A larger difference that the temperatures do not explain is a length that
// jumped, a fringe that was lost, a robot that slipped: the points in between rest on no known
// zero. A robot with play stands elsewhere when it comes from the other side.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/reading.h"
#include "server/core/description/cell_description.h"
#include "server/core/description/closure_rules.h"
#include "server/core/records/closure_records.h"

namespace driftwise::plausibility {

struct Closure {
  CellTime at;
  std::vector<double> lengths_nm;     // since the datum's zero, per length of the cell; kMissing
  std::vector<double> angles_arcsec;  // likewise
  std::optional<double> force_n;
  std::string side = {};               // from which each axis came, "+-"; '?': not known
  std::vector<double> warming_k = {};  // since the datum, per temperature of the cell
  // Pose that a model gives for the readback at these conditions: lengths in nm, then angles in
  // arcsec; empty: no model answers.
  std::vector<double> model_pose = {};
  std::string model = {};  // "model 3"
};

// Expectation of a closure minus its reference. Empty vectors: 0.
struct ExpectedClosure {
  std::vector<double> lengths_nm, lengths_sd_nm, angles_arcsec;
  std::string by;        // "model 3", "4 earlier returns"; empty: nothing
  double warming_k = 0;  // of the temperature that changed most
};

struct ClosureVerdict {
  bool good = true;
  bool explained = false;   // good only because of what was expected
  bool other_side = false;  // the reference came from another side, and the play is not known
  std::string sentence;  // of a bad or explained one: which, how far, the limit, what is expected
  std::vector<ClosureCoordinate> coordinates;
};

class ClosureJudge {
 public:
  // cell: outlives this.
  explicit ClosureJudge(const CellDescription& cell, ClosureRules rules = {})
      : cell_(cell), rules_(std::move(rules)) {}

  // The zero itself, with which every datum begins. Plays that were found stay known.
  void begin(CellTime at, std::optional<double> force_n, std::string side = {});
  void begin(Closure zero);
  // A good closure is what the next one from its side is compared with.
  ClosureVerdict judge(const Closure& closure, const ExpectedClosure& expected = {});
  // What judge() compares this closure with.
  const Closure& reference(const Closure& closure) const;
  // The next one is compared with this, whatever it was.
  void take(const Closure& closure);
  // Two closures at one time, the second from the side of the reference: their difference is play.
  void take_play(const Closure& here, const Closure& there);

  // Of a length from this side against the side of the datum's zero, as far as it was found.
  double play(const std::string& side, std::size_t length) const;

  // Of the last good closure, or the datum's zero.
  CellTime last_good() const { return newest_.at; }

 private:
  using Base = std::vector<double>;  // lengths, then angles: of a side against another
  const Base* base_of(const std::string& side) const;

  const CellDescription& cell_;
  ClosureRules rules_;
  Closure newest_;
  std::string zero_side_;
  std::map<std::string, Closure> of_side_;  // of this datum
  std::map<std::string, Base> plays_;       // of the robot
};

}  // namespace driftwise::plausibility
