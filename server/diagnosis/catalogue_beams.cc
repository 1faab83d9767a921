// What is wrong on the way of a length measurement: interpolation, lever arm, direction, air.

#include <algorithm>
#include <cmath>

#include "server/core/reading.h"
#include "server/core/units.h"
#include "server/diagnosis/catalogue_builder.h"
#include "server/diagnosis/places.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

using effects::AppliesTo;
using effects::Term;

constexpr int kMostPeriods = 4000;
constexpr std::size_t kFewestPlaces = 8;

// Uniform in 1/period, step 1/(2 range), from two periods over the range to half as many as there
// are different places: a finer wave aliases into a coarser one.
void add_cyclic(CatalogueBuilder& builder, const std::string& symbol, Cause cause) {
  std::vector<double> visited;
  const Dataset& data = builder.data();
  const auto values = data.values_of(symbol);
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.set_of(row) == PointSet::calibration) visited.push_back(values[row]);
  const std::size_t places = place_count(visited);
  if (places < kFewestPlaces) {
    builder.missing("cyclic_error", symbol + " is visited at fewer than " +
                                        std::to_string(kFewestPlaces) + " places");
    return;
  }
  const double range_nm = nm_from_mm(builder.range(symbol));
  std::vector<double> periods;
  for (int k = 4; k <= static_cast<int>(places) && k <= kMostPeriods; ++k)
    periods.push_back(2 * range_nm / k);
  builder.add_values(cause, periods, [&](double period) {
    return std::vector<Term>{call_term("sin", {symbol}, {{period, "nm"}}),
                             call_term("cos", {symbol}, {{period, "nm"}})};
  });
  builder.take_cause(std::move(cause));
}

Cause of_instrument(const std::string& id, const std::string& axis, LinearParameter linear) {
  return {.id = id,
          .subject = axis,
          .where = "instrument",
          .applies_to = AppliesTo::correction,
          .linear = linear};
}

// The tilts that move the end of a lever across this axis, or turn its beam: all but the roll.
std::vector<std::string> tilts_across(const CatalogueBuilder& builder, const std::string& axis) {
  std::vector<std::string> tilts;
  for (const auto& tilt : builder.tilts())
    if (tilt != "r" + axis) tilts.push_back(tilt);
  return tilts;
}

// What turns is as long as the beam, and that begins somewhere before x = 0: the tilt alone may
// come with the product.
void add_turned(CatalogueBuilder& builder, const std::string& axis) {
  Cause cause = of_instrument("cosine_error", axis, LinearParameter::angle_arcsec);
  std::vector<Term> all;
  for (const auto& tilt : tilts_across(builder, axis)) {
    all.push_back(effects::product(power_term(axis), power_term(tilt)));
    builder.add_terms(cause, {all.back()}, kMissing);
    builder.add_terms(cause, {all.back(), power_term(tilt)}, kMissing);
  }
  builder.add_terms(cause, all, kMissing);
  builder.take_cause(std::move(cause));
}

void each_and_all(CatalogueBuilder& builder, Cause cause, const std::vector<Term>& terms) {
  for (const auto& term : terms) builder.add_terms(cause, {term}, kMissing);
  builder.add_terms(cause, terms, kMissing);
  builder.take_cause(std::move(cause));
}

}  // namespace

void add_beams(CatalogueBuilder& builder) {
  for (const auto& axis : builder.axes()) {
    Cause wave = of_instrument("cyclic_error", axis, LinearParameter::none);
    wave.parameter = "period_nm";
    wave.scale = ParameterScale::inverse;
    add_cyclic(builder, axis, std::move(wave));
  }
  if (builder.motors().size() > 1)  // of one motor it is the same wave as of its axis
    for (const auto& q : builder.motors())
      add_cyclic(builder, q,
                 {.id = "cyclic_error",
                  .subject = q,
                  .where = "robot",
                  .applies_to = AppliesTo::robot,
                  .parameter = "period_nm",
                  .scale = ParameterScale::inverse,
                  .outputs = {q}});
  bool any_tilt = false;
  // The same tilts stand behind several axes where all outputs are asked: one cause, its axis is
  // told from the outputs afterwards.
  if (builder.axes().size() == 1) {
    const auto& axis = builder.axes().front();
    std::vector<Term> levers;
    for (const auto& tilt : tilts_across(builder, axis)) levers.push_back(power_term(tilt));
    any_tilt = !levers.empty();
    each_and_all(builder, of_instrument("abbe_offset", axis, LinearParameter::offset_mm), levers);
  } else {
    std::vector<Term> levers;
    for (const auto& tilt : builder.tilts()) levers.push_back(power_term(tilt));
    any_tilt = !levers.empty();
    each_and_all(builder, of_instrument("abbe_offset", "", LinearParameter::offset_mm), levers);
  }
  for (const auto& axis : builder.axes()) add_turned(builder, axis);
  if (!any_tilt)
    for (const char* id : {"abbe_offset", "cosine_error"})
      builder.missing(id, "no tilt channel rx, ry, rz in arcsec that varies");

  Cause air{.id = "refractive_index",
            .subject = builder.axes().size() == 1 ? builder.axes().front() : "",
            .where = "environment",
            .applies_to = AppliesTo::correction,
            .linear = LinearParameter::dead_path_mm};
  // An instrument that is told the air's temperature but not its pressure takes out a part of the
  // index, so the parts are tried as well as the whole; on the dead path, on the way measured, on
  // both.
  const auto on_the_path = [&](const std::vector<Term>& parts) {
    builder.add_terms(air, parts, kMissing);
    for (const auto& axis : builder.axes()) {
      std::vector<Term> along, both = parts;
      for (const auto& part : parts) along.push_back(effects::product(power_term(axis), part));
      both.insert(both.end(), along.begin(), along.end());
      builder.add_terms(air, along, kMissing);
      builder.add_terms(air, both, kMissing);
    }
  };
  const bool whole = !builder.data().values_of("air").empty() &&
                     !builder.data().values_of("pressure").empty() &&
                     !builder.data().values_of("humidity").empty();
  bool varies = false;
  std::vector<Term> parts;
  for (const char* symbol : {"air", "pressure", "humidity"})
    if (builder.varies(symbol)) {
      varies = true;
      parts.push_back(power_term(symbol));
    }
  if (!varies)
    builder.missing("refractive_index", "none of air_degC, pressure_hPa, humidity_pct varies");
  else {
    if (whole) on_the_path({call_term("air_index", {"air", "pressure", "humidity"})});
    for (const auto& part : parts) on_the_path({part});
    if (!whole && parts.size() > 1) on_the_path(parts);
  }
  builder.take_cause(std::move(air));
}

}  // namespace driftwise::diagnosis
