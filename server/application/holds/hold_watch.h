#pragma once
// One [[hold]] rule over the values of its channel: when a run has to wait, and when it may go on.
// Pure; the caller states value and time.

#include <cstdint>
#include <optional>
#include <string>

#include "server/core/cell_time.h"
#include "server/core/description/hold_rule.h"

namespace driftwise::application {

class HoldWatch {
 public:
  enum class Phase : std::uint8_t {
    clear,     // within the limits
    exceeded,  // beyond them, for less than for_s
    holding,   // until the value has been within the release limits for settle_s
  };
  enum class Look : std::uint8_t {
    usual,
    before_motion,  // a run begins or is resumed: what is exceeded now holds at once
  };

  explicit HoldWatch(HoldRule rule);

  // value: of the rule's quantity now, in the channel's unit; none: there is none that is young
  // enough, which is as one beyond the limits.
  void look(std::optional<double> value, CellTime now, Look look = Look::usual);

  void clear();  // as if nothing had been seen yet

  const HoldRule& rule() const { return rule_; }
  Phase phase() const { return phase_; }
  // A value has been there once. Before the first one a run waits too, but not for settle_s.
  bool seen() const { return seen_; }
  // A value measured at the last look is beyond the limit, and the measured ones have been for
  // for_s. What cannot be taken back is done for nothing less: not for a missing value, which says
  // nothing of the quantity.
  bool is_measured_beyond(CellTime now) const;
  // It holds, and its value is within the release limits: settle_s is counted.
  bool settles() const { return phase_ == Phase::holding && inside_since_.has_value(); }
  // Since when the limit is exceeded, or was when the hold began; utc_ns 0 while clear.
  CellTime since() const { return since_; }
  // "t12_degC is 21.02, limit 20.5 (hold room)": as it was when the limit was exceeded first.
  // Empty while clear.
  const std::string& sentence() const { return sentence_; }
  // Distance to the release: "t12_degC is 20.31, within its limits for 40 of 60 s". Empty while
  // clear.
  std::string outlook(CellTime now) const;

 private:
  bool is_beyond(const std::optional<double>& value) const;
  bool is_inside(const std::optional<double>& value) const;
  std::string what_exceeds(const std::optional<double>& value) const;
  std::string quantity() const;

  HoldRule rule_;
  Phase phase_ = Phase::clear;
  bool seen_ = false;
  CellTime since_;
  std::optional<CellTime> inside_since_;  // while holding
  std::optional<CellTime> measured_beyond_since_;
  std::optional<double> value_;  // of the last look
  std::string sentence_;
};

}  // namespace driftwise::application
