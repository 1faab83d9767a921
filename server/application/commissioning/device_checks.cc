#include "server/application/commissioning/device_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/core/channel.h"
#include "server/core/units.h"
#include "server/plausibility/limits.h"

namespace driftwise::application {
namespace {

constexpr double kOldestReading_s = 5;
constexpr std::int64_t kSoon_days = 30;

struct Judge {
  const CellDescription& cell;
  const DeviceDescription& device;
  std::vector<CheckItem>& items;

  void add(std::string asked, std::string found, std::string expected, Finding finding,
           std::string advice = {}) const {
    items.push_back({device.id, std::move(asked), std::move(found), std::move(expected), finding,
                     finding == Finding::good ? std::string() : std::move(advice)});
  }
};

void check_identity(const Judge& judge, const Heard& heard) {
  const auto& expected = judge.device.identity;
  const auto& found = heard.status.health.identity;
  if (expected.empty())
    return judge.add(
        "identity", found, "not declared", Finding::unknown,
        fmt::format("declare it: identity = \"...\" in [[device]] {}", judge.device.id));
  const bool same = found.find(expected) != std::string::npos;
  judge.add("identity", found.empty() ? "none" : found, fmt::format("contains '{}'", expected),
            same ? Finding::good : Finding::bad,
            "another device answers at this address: look at the cables, or correct the cell file "
            "and its declared uncertainties");
}

// A device that answers something else than declared has power, cable and address.
std::string advice_after(const Error& trouble, bool is_linked) {
  if (is_linked) return "the device's own words say what to look at";
  const bool is_silent =
      trouble.code == ErrorCode::unavailable || trouble.code == ErrorCode::deadline_exceeded;
  return is_silent ? "look at power, cable and address"
                   : "it answers, but not as declared: correct the cell file or the device";
}

std::string bound(double value) {
  return std::abs(value) > 1e300 ? std::string("any") : fmt::format("{:g}", value);
}

void check_range(const Judge& judge, const JudgedReading& reading) {
  for (const auto& value : reading.values) {
    const auto unit = value.channel.substr(value.channel.rfind('_') + 1);
    const auto limit = plausibility::limit_of(judge.cell, judge.device, value.channel);
    const auto rejected =
        std::ranges::find(reading.rejected, value.channel, &RejectedValue::channel);
    const bool bad = rejected != reading.rejected.end();
    const std::string found =
        is_missing(value.value) ? "no value" : fmt::format("{:.6g} {}", value.value, unit);
    const bool any = std::abs(limit.min) > 1e300 && std::abs(limit.max) > 1e300;
    judge.add("range of " + value.channel, found,
              any ? "a finite value"
                  : fmt::format("{} to {} {}", bound(limit.min), bound(limit.max), unit),
              bad || is_missing(value.value) ? Finding::bad : Finding::good,
              bad ? rejected->reason : "look at its sensor and cable");
    if (is_light_level(value.channel) && !is_missing(value.value))
      judge.add("light level", fmt::format("{:.0f} %", value.value),
                fmt::format("at least {:g} %", kEnoughLight_pct),
                value.value >= kEnoughLight_pct ? Finding::good : Finding::warning,
                "align beam and mirror ('driftwise align' shows the level), clean the optics");
  }
}

struct Resolution {
  double step = 0, sd = 0;  // smallest difference between two answers; standard deviation
};

Resolution resolution_of(const std::vector<double>& values) {
  Resolution out;
  double mean = 0;
  const double n = static_cast<double>(values.size());
  for (const double value : values) mean += value / n;
  for (const double value : values) out.sd += (value - mean) * (value - mean) / (n - 1);
  out.sd = std::sqrt(out.sd);
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = std::abs(values[i] - values[i - 1]);
    // Two answers of the same digits differ by the rounding of doubles only (a mean, a zero taken
    // off): no instrument resolves a part in 1e12.
    const double rounding = 1e-12 * std::max(std::abs(values[i]), std::abs(values[i - 1]));
    if (step > rounding && (out.step == 0 || step < out.step)) out.step = step;
  }
  return out;
}

// The gate asks for max_spread_nm within a point; what is declared is what the budget counts with.
void check_resolution(const Judge& judge, const Heard& heard, const std::string& channel,
                      double declared, double wanted, const char* unit, double per_unit) {
  std::vector<double> values;
  for (const auto& reading : heard.readings)
    if (const double* value = reading.find(channel); value != nullptr && !is_missing(*value))
      values.push_back(*value * per_unit);
  if (values.size() < 4) return;
  const auto found = resolution_of(values);
  const double limit = declared > 0 ? 2 * declared : wanted;
  if (!(limit > 0))
    return judge.add("resolution of " + channel, fmt::format("spread {:.2g} {}", found.sd, unit),
                     "not declared", Finding::unknown, "declare its uncertainty in the cell file");
  const bool coarse = wanted > 0 && found.sd > wanted;
  judge.add("resolution of " + channel,
            fmt::format("spread {:.2g} {} in {} readings, {}", found.sd, unit, values.size(),
                        found.step > 0 ? fmt::format("smallest step {:.2g} {}", found.step, unit)
                                       : std::string("all equal")),
            declared > 0
                ? fmt::format("spread of at most twice the declared {:g} {}", declared, unit)
                : fmt::format("spread of at most {:g} {}, the gate of a point", limit, unit),
            coarse              ? Finding::bad
            : found.sd <= limit ? Finding::good
                                : Finding::warning,
            coarse ? "points will not pass the gate: look for vibration, turbulence and light"
                   : "noisier than declared: look for vibration and turbulence, or declare it");
}

void check_resolutions(const Judge& judge, const Heard& heard) {
  if (const auto* length = judge.device.length())
    check_resolution(judge, heard, length->channel.name(), length->u_length_nm,
                     judge.cell.run.max_spread_nm, "nm", 1e6);
  for (const auto& angle : judge.device.angles())
    check_resolution(judge, heard, angle.channel.name(), angle.u_arcsec, 0, "arcsec", 1);
}

void check_clock(const Judge& judge, const Heard& heard, CellTime now, std::int64_t utc_ns,
                 double speed) {
  if (heard.readings.empty()) return;
  const double age_s = seconds_from(now - heard.readings.back().middle());
  const double limit_s = std::max(kOldestReading_s, judge.device.timeout_s) * std::max(1.0, speed);
  judge.add("time of the reading", fmt::format("{:.2f} s ago", age_s),
            fmt::format("0 to {:g} s ago", limit_s),
            age_s >= -1 && age_s <= limit_s ? Finding::good : Finding::bad,
            "its answers are late or its stamps are wrong: look at the link and at its clock");
  const auto& health = heard.status.health;
  if (!health.clock_offset) return;
  const double off_s = seconds_from(*health.clock_offset - Nanoseconds(utc_ns - now.utc_ns));
  const double shown_s = std::round(100 * off_s) / 100 + 0.0;  // no "-0.00"
  judge.add("clock", fmt::format("{:+.2f} s from this computer's UTC", shown_s),
            fmt::format("within {:g} s", health.max_clock_offset_s),
            std::abs(off_s) <= health.max_clock_offset_s ? Finding::good : Finding::warning,
            "set its clock; readings count by the measured offset meanwhile");
}

bool is_measuring(DeviceRole role) {
  return measures_pose(role) || role == DeviceRole::temperature || role == DeviceRole::force ||
         role == DeviceRole::environment;
}

void check_certificates(const Judge& judge, std::int64_t utc_ns) {
  bool any = false;
  for (const auto& one : judge.cell.certificates) {
    if (one.device != judge.device.id) continue;
    any = true;
    const auto left = one.days_left(utc_ns);
    const auto found = fmt::format("{} of {}, {}", one.number, one.laboratory, one.date);
    if (!left) {
      judge.add("certificate", found, "no due date stated", Finding::good);
      continue;
    }
    judge.add("certificate", found,
              *left < 0 ? fmt::format("due {}: {} days overdue", one.due, -*left)
                        : fmt::format("due {}, in {} days", one.due, *left),
              *left < kSoon_days ? Finding::warning : Finding::good,
              *left < 0 ? "have it calibrated; the budget counts with an old certificate"
                        : "have it calibrated soon");
  }
  if (!any && is_measuring(judge.device.role()))
    judge.add("certificate", "none", "not declared", Finding::unknown,
              fmt::format("declare it: [[certificate]] device = \"{}\"", judge.device.id));
}

void check_motion(const Judge& judge, const MotionState& state) {
  judge.add("reference", state.referenced ? "referenced" : "not referenced", "referenced",
            state.referenced ? Finding::good : Finding::warning, "home the axes");
  for (std::size_t i = 0; i < judge.device.axes().size() && i < state.q_mm.size(); ++i) {
    const auto& axis = judge.device.axes()[i];
    const bool inside = state.q_mm[i] >= axis.min_mm && state.q_mm[i] <= axis.max_mm;
    judge.add("position of " + axis.channel.name(), fmt::format("{:.6f} mm", state.q_mm[i]),
              fmt::format("{:g} to {:g} mm", axis.min_mm, axis.max_mm),
              inside ? Finding::good : Finding::warning,
              "it is outside its soft limits: look at the reference, then home");
  }
}

}  // namespace

Finding CellCheck::worst() const {
  auto worst = Finding::good;
  for (const auto& item : items)
    if (item.finding != Finding::unknown) worst = std::max(worst, item.finding);
  return worst;
}

std::vector<CheckItem> check_device(const CellDescription& cell, const Heard& heard, CellTime now,
                                    std::int64_t utc_ns, double speed) {
  std::vector<CheckItem> items;
  const auto& device = heard.status.description;
  const Judge judge{cell, device, items};
  if (heard.trouble) {
    const bool is_linked = heard.status.health.link == LinkState::connected;
    judge.add(is_linked ? "reading" : "answer", heard.trouble->message,
              is_linked ? "a reading" : "an answer at " + device.address, Finding::bad,
              advice_after(*heard.trouble, is_linked));
    if (!is_linked) {
      check_certificates(judge, utc_ns);
      return items;
    }
  } else {
    judge.add("answer", fmt::format("after {:.0f} ms", 1000 * heard.status.health.last_latency_s),
              "an answer at " + device.address, Finding::good);
  }
  check_identity(judge, heard);
  if (heard.motion) check_motion(judge, *heard.motion);
  if (!heard.readings.empty() && !heard.motion) check_range(judge, heard.readings.back());
  check_resolutions(judge, heard);
  check_clock(judge, heard, now, utc_ns, speed);
  check_certificates(judge, utc_ns);
  return items;
}

std::vector<OverdueCertificate> overdue_certificates(const CellDescription& cell,
                                                     std::int64_t utc_ns) {
  std::vector<OverdueCertificate> out;
  for (const auto& one : cell.certificates)
    if (const auto left = one.days_left(utc_ns); left && *left < 0)
      out.push_back({one.device + " " + one.number,
                     fmt::format("certificate {} of {} ({}) was due on {}: have {} calibrated; the "
                                 "uncertainty budget counts with an old certificate",
                                 one.number, one.device, one.laboratory, one.due, one.device)});
  return out;
}

}  // namespace driftwise::application
