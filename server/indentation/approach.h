#pragma once
// One approach of the robot below to the robot above, in steps, until they touch: what to do next,
// from what was seen. The caller moves and looks; a person's program, a test and a count use the
// same decisions. Pure; one thread.
//
// The reference is the rest while the robots are clearly apart, read before the robot below rises
// to depart_mm: a height in contact already has no free window to compare with. A sign at depart_mm
// is then a contact that was there before the first step, and no height.

#include <string>

#include "server/indentation/contact_detector.h"

namespace driftwise::indentation {

struct ApproachRule {
  ContactRule contact{};
  double depart_mm = 0;      // height from which it begins, the operator's
  double highest_mm = 0;     // never higher
  double step_mm = 0.00025;  // one count of the study's scale
  int most_steps = 400;
};

class Approach {
 public:
  // Errors: invalid_argument BAD_RULE with the key that is wrong and what is allowed.
  static Result<Approach> create(const ApproachRule& rule);

  struct Next {
    enum class Kind {
      rest,        // clearly apart, where the robot below stands: read a window; nothing moves
      look,        // at height_mm, which was reached before: read another window
      move,        // to height_mm, then read a window
      contact,     // over
      touching,    // over: in contact at depart_mm already; no height
      no_contact,  // over: the highest place, or as many steps as allowed, without contact
      abort,       // over: retract, then look for the cause
    };
    Kind kind = Kind::move;
    // Of the robot below: where it is or goes; rest: where it goes afterwards; contact: the
    // estimate.
    double height_mm = 0;
    double u_nm = 0;    // contact: standard uncertainty by the step, step / root of 12
    std::string why{};  // no_contact, touching, abort: figures, and what to do
  };

  Next begin() const { return {.kind = Next::Kind::rest, .height_mm = rule_.depart_mm}; }
  // After begin() and after each answer rest, look or move. Errors: those of ContactDetector::add.
  Result<Next> next(const Eigen::Ref<const Eigen::MatrixXd>& holding_error_nm);

  int steps() const { return steps_; }
  double height_mm() const { return height_mm_; }
  const ContactDetector& detector() const { return detector_; }

 private:
  explicit Approach(const ApproachRule& rule)
      : rule_(rule), detector_(rule.contact), height_mm_(rule.depart_mm) {}

  ApproachRule rule_;
  ContactDetector detector_;
  double height_mm_;
  int rests_ = 0, steps_ = 0;
};

}  // namespace driftwise::indentation
