// What has no other witness than the clock: drift, a jump, something periodic.

#include <algorithm>
#include <cmath>

#include "server/core/data/reading.h"
#include "server/diagnosis/catalogue/catalogue_builder.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

using effects::AppliesTo;
using effects::Term;

constexpr std::size_t kFewestBesideStep = 4, kMostInstants = 800;
constexpr double kMostPeriodsInTime = 4000;  // half turns over the data

}  // namespace

void add_time(CatalogueBuilder& builder) {
  if (!builder.timed()) {
    for (const char* id : {"instrument_drift", "step_change", "periodic_disturbance"})
      builder.missing(id, "the data have no time_s");
    return;
  }
  const Dataset& data = builder.data();
  const std::string axis = builder.axes().size() == 1 ? builder.axes().front() : "";
  Cause drift{.id = "instrument_drift",
              .subject = axis,
              .where = "instrument",
              .applies_to = AppliesTo::correction,
              .linear = LinearParameter::nm_per_h};
  const Term zero = call_term("drift", {});
  builder.add_terms(drift, {zero}, kMissing);
  for (const auto& of : builder.axes()) {  // and its scale: a laser that warms up, air that ages
    const Term scale = effects::product(power_term(of), zero);
    builder.add_terms(drift, {scale}, kMissing);
    builder.add_terms(drift, {zero, scale}, kMissing);
  }
  builder.take_cause(std::move(drift));

  Cause step{.id = "step_change",
             .subject = axis,
             .where = "data",
             .applies_to = AppliesTo::dataset,
             .parameter = "time_s",
             .scale = ParameterScale::instant,
             .linear = LinearParameter::size_nm};
  // Before every row that learns: an instant that is one row off leaves a strong jump standing
  // there, and slow noise then describes it better.
  std::vector<double> all, instants;
  for (std::size_t i = kFewestBesideStep; i + kFewestBesideStep < data.rows; ++i)
    if (data.time_s[i] > data.time_s[i - 1] && data.set_of(i) == PointSet::calibration)
      all.push_back((data.time_s[i - 1] + data.time_s[i]) / 2);
  const std::size_t every = std::max<std::size_t>(1, all.size() / kMostInstants);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (i % every == 0 || i < 5 * every || i + 5 * every > all.size()) instants.push_back(all[i]);
  builder.add_values(step, instants, [](double at) {
    return std::vector<Term>{call_term("step", {}, {{at, "s"}})};
  });
  builder.take_cause(std::move(step));

  Cause wave{.id = "periodic_disturbance",
             .subject = axis,
             .where = "environment",
             .applies_to = AppliesTo::correction,
             .parameter = "period_s",
             .scale = ParameterScale::inverse};
  std::vector<double> periods;
  const double length_s = builder.length_s();
  const double turns = std::min(std::ceil(length_s / builder.step_s()) - 1, kMostPeriodsInTime);
  const double apart = wave_step(length_s, static_cast<std::size_t>(std::max(turns, 0.0)));
  const double last = turns / (2 * length_s) * (1 + 1e-9);
  for (double k = std::round(2 / length_s / apart); k * apart <= last; ++k)
    periods.push_back(1 / (k * apart));
  builder.add_values(wave, periods, [](double period) {
    return std::vector<Term>{call_term("sin_t", {}, {{period, "s"}}),
                             call_term("cos_t", {}, {{period, "s"}})};
  });
  // Air conditioning, the day, people: no scale of time is likelier than another, so that every
  // octave of periods has the same odds. The cells lie evenly in 1 / period.
  for (auto& cell : wave.cells) cell.weight = cell.parameter;
  builder.take_cause(std::move(wave));
}

}  // namespace driftwise::diagnosis
