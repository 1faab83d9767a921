#pragma once
// What follows a run of the queue that is done, as a person writes it. Pure.
//
//   fit:q ~ x + x^2 + R   a model of that formula, proposed
//   diagnose              a diagnosis from the baseline in force
//   diagnose:q ~ x        a diagnosis from this baseline
//   report                a page of one file beside the database: report/reports.h
//   notify                an alarm at level notice: the entry is done

#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::application {

struct FollowUp {
  enum class Kind { fit, diagnose, report, notify };
  Kind kind = Kind::notify;
  std::string formula;  // of fit and diagnose; empty: none given
};

// Errors: invalid_argument BAD_FOLLOW_UP; BAD_FORMULA where the formula cannot be read.
Result<FollowUp> parse_follow_up(std::string_view text);

}  // namespace driftwise::application
