#include "server/application/datasets/extension_preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/datasets/instruments.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

constexpr double kSeen_nm = 0.1;

// Three significant digits, without an exponent.
std::string nm_text(double nm) {
  const int decimals = nm >= 99.95 || nm == 0 ? 0 : nm >= 9.995 ? 1 : 2;
  const double step = nm >= 999.5 ? std::pow(10, std::floor(std::log10(nm)) - 2) : 1;
  return fmt::format("{:.{}f} nm", nm >= 999.5 ? std::round(nm / step) * step : nm, decimals);
}

}  // namespace

Result<std::vector<LengthChange>> length_changes(Store& store, RunId run,
                                                 const correction::DataAmendment& amendment) {
  DRIFTWISE_TRY(const auto before, amended_data(store, {&run, 1}));
  correction::DataAmendment shifts;
  shifts.shifts = amendment.shifts;
  DRIFTWISE_TRY(shifts, held_for(store, std::move(shifts), {&run, 1}));
  Dataset after = before.data;
  DRIFTWISE_RETURN_IF_ERROR(correction::amend(shifts, before.origins, before.time_zero, after));
  std::vector<LengthChange> changes;
  for (std::size_t c = 0; c < after.columns.size(); ++c) {
    const auto& channel = after.columns[c].channel;
    if (!is_length(channel.unit)) continue;
    const double nm_per_unit = summary_unit(channel.unit).factor;
    LengthChange change;
    change.run = run;
    change.channel = channel.name();
    double square = 0, count = 0;
    for (std::size_t row = 0; row < after.rows; ++row) {
      const double nm = std::abs(
          nm_per_unit * (after.columns[c].values[row] - before.data.columns[c].values[row]));
      if (!std::isfinite(nm)) continue;
      square += nm * nm, count += 1;
      change.largest_nm = std::max(change.largest_nm, nm);
      if (nm < kSeen_nm || change.rows++ > 0) continue;
      if (before.time_zero.utc_ns != 0 && !after.time_s.empty())
        change.from = before.time_zero + nanoseconds_from_s(after.time_s[row]);
    }
    if (change.rows == 0) continue;
    change.rms_nm = std::sqrt(square / count);
    changes.push_back(std::move(change));
  }
  return changes;
}

bool concerns_every_run(const correction::DataAmendment& amendment) {
  const auto is_everywhere = [](const auto& shift) { return shift.runs.empty(); };
  return std::ranges::any_of(amendment.shifts, is_everywhere) ||
         std::ranges::any_of(amendment.angles, is_everywhere);
}

bool concerns(const correction::DataAmendment& amendment, const RunRecord& record) {
  const RunId run = record.id;
  const auto names_it = [run](const auto& shift) {
    return std::ranges::find(shift.runs, run) != shift.runs.end();
  };
  return (concerns_every_run(amendment) && !is_of_file(record)) ||
         std::ranges::any_of(amendment.shifts, names_it) ||
         std::ranges::any_of(amendment.angles, names_it) ||
         std::ranges::find(amendment.splits, run, &correction::DatumSplit::run) !=
             amendment.splits.end() ||
         std::ranges::find(amendment.sensors, run, &correction::SensorLeftOut::run) !=
             amendment.sensors.end();
}

std::string sentence(const LengthChange& change, const Clock& clock) {
  return fmt::format(
      "{} of run {}{} by up to {} (rms {}) in {} row{}{}", change.channel, change.run.value,
      change.run_name.empty() ? "" : fmt::format(" '{}'", change.run_name),
      nm_text(change.largest_nm), nm_text(change.rms_nm), change.rows, change.rows == 1 ? "" : "s",
      change.from.utc_ns == 0 ? "" : ", from " + to_iso8601(clock.utc(change.from)));
}

}  // namespace driftwise::application
