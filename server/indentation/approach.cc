#include "server/indentation/approach.h"

#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::indentation {
namespace {

tl::unexpected<Error> bad(const std::string& what) {
  return fail(ErrorCode::invalid_argument, reasons::kBadRule, "approach: " + what);
}

}  // namespace

Result<Approach> Approach::create(const ApproachRule& rule) {
  if (!(rule.step_mm > 0 && rule.step_mm <= 0.01))
    return bad("step_mm is " + number_text(rule.step_mm) + ", allowed is above 0 to 0.01 mm");
  if (rule.most_steps < 1)
    return bad("most_steps is " + std::to_string(rule.most_steps) + ", allowed is 1 and more");
  if (!std::isfinite(rule.depart_mm) || !(rule.highest_mm > rule.depart_mm))
    return bad("highest_mm " + number_text(rule.highest_mm) + " is not above depart_mm " +
               number_text(rule.depart_mm) + ": begin lower");
  const auto& c = rule.contact;
  if (!(c.threshold_nm > 0 && c.abort_nm > c.threshold_nm))
    return bad("threshold_nm is " + number_text(c.threshold_nm) + " and abort_nm " +
               number_text(c.abort_nm) + ": both above 0, the second larger");
  if (c.baseline_windows < 1) return bad("baseline_windows is below 1");
  return Approach(rule);
}

Result<Approach::Next> Approach::next(const Eigen::Ref<const Eigen::MatrixXd>& holding_error_nm) {
  using Verdict = ContactDetector::Verdict;
  DRIFTWISE_TRY(const auto verdict, detector_.add(holding_error_nm));
  if (verdict == Verdict::baseline)
    return ++rests_ < rule_.contact.baseline_windows
               ? begin()
               : Next{.kind = Next::Kind::move, .height_mm = height_mm_};
  if (verdict == Verdict::look_again)
    return Next{.kind = Next::Kind::look, .height_mm = height_mm_};
  const double off_nm = std::round(detector_.shift_nm().cwiseAbs().maxCoeff());
  if (verdict == Verdict::contact && steps_ == 0)
    return Next{
        .kind = Next::Kind::touching,
        .height_mm = height_mm_,
        .why = "in contact at " + digits_text(height_mm_, 7) +
               " mm already, where the approach was to begin: the holding error is off by " +
               number_text(off_nm) +
               " nm of the rest before, so the surface is lower by an unknown way and the "
               "tool was driven into it: retract, begin lower"};
  const double step_nm = nm_from_mm(rule_.step_mm);
  if (verdict == Verdict::contact)
    return Next{.kind = Next::Kind::contact,
                .height_mm = height_mm_ - rule_.step_mm / 2,
                .u_nm = step_nm / std::sqrt(12.0)};
  if (verdict == Verdict::abort)
    return Next{.kind = Next::Kind::abort,
                .height_mm = height_mm_,
                .why = detector_.shift_nm().cwiseAbs().maxCoeff() <= rule_.contact.abort_nm
                           ? "the holding error swings: " + std::to_string(kMostLooks) +
                                 " looks in succession neither agree on a contact nor on none: "
                                 "retract, look for what shakes the robot"
                           : "the holding error at " + digits_text(height_mm_, 7) + " mm, " +
                                 std::to_string(steps_) + " steps up, is off by " +
                                 number_text(off_nm) + " nm, the limit is " +
                                 number_text(rule_.contact.abort_nm) +
                                 " nm: retract, look for what pushes the robot, begin lower"};
  if (steps_ >= rule_.most_steps || height_mm_ + rule_.step_mm > rule_.highest_mm)
    return Next{.kind = Next::Kind::no_contact,
                .height_mm = height_mm_,
                .why = "no contact in " + std::to_string(steps_) + " steps up to " +
                       number_text(height_mm_) +
                       " mm: check the work-piece, begin higher or allow more steps"};
  ++steps_;
  height_mm_ = rule_.depart_mm + steps_ * rule_.step_mm;
  return Next{.kind = Next::Kind::move, .height_mm = height_mm_};
}

}  // namespace driftwise::indentation
