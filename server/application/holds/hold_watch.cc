#include "server/application/holds/hold_watch.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace driftwise::application {

HoldWatch::HoldWatch(HoldRule rule) : rule_(std::move(rule)) {}

bool HoldWatch::is_beyond(const std::optional<double>& value) const {
  if (!value || std::isnan(*value)) return true;
  return (rule_.above && *value > *rule_.above) || (rule_.below && *value < *rule_.below);
}

bool HoldWatch::is_inside(const std::optional<double>& value) const {
  if (is_beyond(value)) return false;
  return !(rule_.release_above && *value > *rule_.release_above) &&
         !(rule_.release_below && *value < *rule_.release_below);
}

std::string HoldWatch::quantity() const {
  return rule_.minus.empty() ? rule_.channel : fmt::format("{} - {}", rule_.channel, rule_.minus);
}

std::string HoldWatch::what_exceeds(const std::optional<double>& value) const {
  if (!value || std::isnan(*value))
    return fmt::format("{} has no fresh value (hold {})", quantity(), rule_.name);
  const bool is_above = rule_.above && *value > *rule_.above;
  return fmt::format("{} is {:.6g}, limit {:.6g} (hold {})", quantity(), *value,
                     is_above ? *rule_.above : rule_.below.value_or(0), rule_.name);
}

bool HoldWatch::is_measured_beyond(CellTime now) const {
  return value_ && !std::isnan(*value_) && measured_beyond_since_ &&
         seconds_from(now - *measured_beyond_since_) >= rule_.for_s;
}

void HoldWatch::clear() {
  phase_ = Phase::clear;
  since_ = {};
  inside_since_.reset();
  sentence_.clear();
}

void HoldWatch::look(std::optional<double> value, CellTime now, Look look) {
  value_ = value;
  if (value && !std::isnan(*value)) {
    if (!is_beyond(value))
      measured_beyond_since_.reset();
    else if (!measured_beyond_since_)
      measured_beyond_since_ = now;
  }
  if (value && !std::exchange(seen_, true)) clear();
  if (phase_ != Phase::holding) {
    if (!is_beyond(value)) return clear();
    if (phase_ == Phase::clear) {
      phase_ = Phase::exceeded;
      since_ = now;
      sentence_ = what_exceeds(value);
    }
    const bool is_long_enough = seconds_from(now - since_) >= rule_.for_s;
    if (!is_long_enough && look == Look::usual) return;
    phase_ = Phase::holding;
    inside_since_.reset();
    return;
  }
  if (!is_inside(value)) {
    inside_since_.reset();
    return;
  }
  if (!inside_since_) inside_since_ = now;
  if (seconds_from(now - *inside_since_) >= rule_.settle_s) clear();
}

std::string HoldWatch::outlook(CellTime now) const {
  if (phase_ == Phase::clear) return {};
  const std::string value = value_ && !std::isnan(*value_)
                                ? fmt::format("{} is {:.6g}", quantity(), *value_)
                                : fmt::format("{} has no fresh value", quantity());
  if (phase_ == Phase::exceeded)
    return fmt::format("{}, beyond its limit for {:.0f} of {:g} s", value,
                       seconds_from(now - since_), rule_.for_s);
  if (!inside_since_)
    return fmt::format(
        "{}; the run goes on when it has been within {} for {:g} s", value,
        rule_.release_above || rule_.release_below ? "its release limits" : "its limits",
        rule_.settle_s);
  return fmt::format("{}, within its limits for {:.0f} of {:g} s", value,
                     seconds_from(now - *inside_since_), rule_.settle_s);
}

}  // namespace driftwise::application
