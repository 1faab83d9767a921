// What is wrong on the way of a length measurement: interpolation, lever arm, direction, air.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <span>

#include "server/core/data/reading.h"
#include "server/core/units.h"
#include "server/diagnosis/catalogue/catalogue_builder.h"
#include "server/diagnosis/rows/places.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

using effects::AppliesTo;
using effects::Term;

constexpr std::size_t kFewestPlaces = 8, kMostPlaces = 4000;  // the search's blocks
// Interpolation errors repeat with the signal's period over small integers: half and quarter
// wavelengths of a helium-neon laser, pitches of scales and leads of screws.
constexpr std::array<double, 17> kPeriods_nm = {632.8, 512, 1e3, 2e3, 4e3, 8e3, 10e3, 20e3, 40e3,
                                                50e3,  1e5, 2e5, 5e5, 1e6, 2e6, 5e6,  10e6};
// Lines of angle encoders, 36000 to 1024 a turn, and teeth of worm wheels, 360 to 60: usual counts,
// taken from no one source.
constexpr std::array<double, 16> kPeriods_arcsec = {36,       72,    129.6, 144,      259.2, 360,
                                                    632.8125, 648,   720,   1265.625, 3600,  7200,
                                                    10800,    14400, 18000, 21600};
constexpr std::array<int, 4> kParts = {1, 2, 4, 8};
// Times a turn: a disk off its centre, an elliptic one, three jaws, four screws, and so on.
constexpr double kTurn_arcsec = 1296000;
constexpr std::array<int, 7> kTimesATurn = {1, 2, 3, 4, 5, 6, 8};
constexpr double kTolerance = 2e-4;    // of a period: wavelength in air, expansion, alignment
constexpr double kPhysicalMass = 0.7;  // of the prior over periods; the rest is any period's
constexpr int kMostOfOne = 20;         // cells to either side of a known period

// All in nm, or in arcsec.
struct Waves {
  std::vector<double> periods, weights;  // longest first
  double shortest_free = 0, shortest = 0;
};

// Any period, uniform in 1/period with wave_step(), from two periods over the range to half as many
// as there are different places, for more of them look alike there; and around each known period
// that the places resolve. turn: whole parts of it are known where half a period is seen; 0: none.
Waves waves_of(double range, std::span<const double> periods, std::size_t places, double turn = 0) {
  std::map<double, double> by_frequency;  // weight
  std::vector<double> free;
  const std::size_t turns = std::min(places, kMostPlaces);  // half turns over the range
  const double step = wave_step(range, turns);
  const double last = static_cast<double>(turns) / (2 * range);
  for (double k = std::round(2 / range / step); k * step <= last * (1 + 1e-9); ++k)
    free.push_back(k * step);
  std::set<double> known;
  for (const double period : periods)
    for (const int part : kParts)
      if (period / part < range / 2) known.insert(part / period);
  if (turn > 0)
    for (const int times : kTimesATurn)
      if (turn / times <= 2 * range && times / turn <= last) known.insert(times / turn);
  for (const double frequency : known) {
    const int beside =
        std::min(kMostOfOne, static_cast<int>(std::ceil(kTolerance * frequency / step)));
    const double apart = beside > 0 ? kTolerance * frequency / beside : 0;
    for (int i = -beside; i <= beside; ++i)
      by_frequency[frequency + i * apart] +=
          kPhysicalMass / (2 * beside + 1) / static_cast<double>(known.size());
  }
  const double rest = known.empty() ? 1 : 1 - kPhysicalMass;
  for (const double frequency : free)
    by_frequency[frequency] += rest / static_cast<double>(free.size());
  Waves waves;
  for (const auto& [frequency, weight] : by_frequency) {
    waves.periods.push_back(1 / frequency);
    waves.weights.push_back(weight);
  }
  if (!free.empty()) waves.shortest_free = 1 / free.back();
  if (!by_frequency.empty()) waves.shortest = 1 / by_frequency.rbegin()->first;
  return waves;
}

// Visits of one commanded position of all motors together are one place; without motors, of the
// coordinate itself.
std::size_t places_of(const CatalogueBuilder& builder, const std::string& symbol) {
  const Dataset& data = builder.data();
  std::vector<std::vector<double>> coordinates;
  if (!is_motor_symbol(symbol))
    for (const auto& q : builder.motors()) {
      const auto values = data.values_of(q);
      coordinates.push_back(by_places({values.begin(), values.end()}));
    }
  if (coordinates.empty()) {
    const auto values = data.values_of(symbol);
    coordinates.push_back(by_places({values.begin(), values.end()}));
  }
  std::set<std::vector<double>> places;
  // Rows for validation count where there are no others: the search then learns from them.
  const bool any_learns =
      data.set.empty() || std::ranges::count(data.set, PointSet::calibration) > 0;
  for (std::size_t row = 0; row < data.rows; ++row) {
    if (any_learns && data.set_of(row) != PointSet::calibration) continue;
    std::vector<double> place;
    for (const auto& one : coordinates) place.push_back(one[row]);
    if (std::ranges::all_of(place, [](double v) { return std::isfinite(v); })) places.insert(place);
  }
  return places.size();
}

std::string short_size(double size, bool angle) {
  std::array<char, 32> text{};
  const double nm = size;
  if (angle) {
    std::snprintf(text.data(), text.size(), "%.3g arcsec", size);
    return text.data();
  }
  if (nm >= 1e5)
    std::snprintf(text.data(), text.size(), "%.3g mm", nm / 1e6);
  else
    std::snprintf(text.data(), text.size(), nm >= 1e3 ? "%.3g um" : "%.3g nm",
                  nm >= 1e3 ? nm / 1e3 : nm);
  return text.data();
}

// Longest period of a motor's wave that is not the same wave as of the axis. With one motor and one
// axis they differ by what the structure between scale and pose does: its phase must tell them
// apart by half a radian.
double longest_of_its_own(const CatalogueBuilder& builder) {
  if (builder.motors().size() > 1 || builder.axes().empty())
    return std::numeric_limits<double>::infinity();
  if (builder.axes().size() != 1) return 0;
  const auto q = builder.data().values_of(builder.motors().front());
  const auto x = builder.data().values_of(builder.axes().front());
  const StraightLine line = straight_line(q, x);
  if (line.slope == 0) return 0;
  const double apart = line.left_rms / std::abs(line.slope);  // a turn may become a way
  return 4 * std::numbers::pi *
         (builder.is_angle(builder.motors().front()) ? apart : nm_from_mm(apart));
}

void add_cyclic(CatalogueBuilder& builder, const std::string& symbol, Cause cause,
                std::vector<std::string>& reach,
                double longest = std::numeric_limits<double>::infinity()) {
  const bool angle = builder.is_angle(symbol);
  if (angle) cause.parameter = "period_arcsec";

  const std::size_t places = places_of(builder, symbol);
  if (places < kFewestPlaces) {
    reach.push_back(symbol + " is visited at fewer than " + std::to_string(kFewestPlaces) +
                    " places");
    return;
  }
  const double range = builder.range(symbol);
  Waves waves = angle ? waves_of(range, kPeriods_arcsec, places, kTurn_arcsec)
                      : waves_of(nm_from_mm(range), kPeriods_nm, places);
  const auto kept = std::ranges::find_if(waves.periods, [&](double p) { return p < longest; });
  waves.weights.erase(waves.weights.begin(),
                      waves.weights.begin() + (kept - waves.periods.begin()));
  waves.periods.erase(waves.periods.begin(), kept);
  if (waves.periods.empty()) return;
  const char* unit = angle ? "arcsec" : "nm";
  builder.add_values(cause, waves.periods, [&](double period) {
    return std::vector<Term>{call_term("sin", {symbol}, {{period, unit}}),
                             call_term("cos", {symbol}, {{period, unit}})};
  });
  for (std::size_t c = 0; c < cause.cells.size(); ++c) cause.cells[c].weight = waves.weights[c];
  reach.push_back("periods of " + symbol + " below " + short_size(waves.shortest_free, angle) +
                  " other than those of scales and lasers (down to " +
                  short_size(waves.shortest, angle) + "): " + std::to_string(places) +
                  " places determine no more");
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
// come with the product. A beam that stands square loses the tilt's square, mostly of the path
// before x = 0.
void add_turned(CatalogueBuilder& builder, const std::string& axis) {
  Cause cause = of_instrument("cosine_error", axis, LinearParameter::angle_arcsec);
  std::vector<Term> all, squares;
  for (const auto& tilt : tilts_across(builder, axis)) {
    all.push_back(effects::product(power_term(axis), power_term(tilt)));
    squares.push_back(power_term(tilt, 2));
    builder.add_terms(cause, {all.back()}, kMissing);
    builder.add_terms(cause, {all.back(), power_term(tilt)}, kMissing);
    builder.add_terms(cause, {squares.back()}, kMissing);
  }
  builder.add_terms(cause, all, kMissing);
  builder.add_terms(cause, squares, kMissing);
  builder.take_cause(std::move(cause));
}

void each_and_all(CatalogueBuilder& builder, Cause cause, const std::vector<Term>& terms) {
  for (const auto& term : terms) builder.add_terms(cause, {term}, kMissing);
  builder.add_terms(cause, terms, kMissing);
  builder.take_cause(std::move(cause));
}

}  // namespace

void add_beams(CatalogueBuilder& builder) {
  std::vector<std::string> reach;
  for (const auto& axis : builder.axes()) {
    Cause wave = of_instrument("cyclic_error", axis, LinearParameter::none);
    wave.parameter = "period_nm";
    wave.scale = ParameterScale::inverse;
    add_cyclic(builder, axis, std::move(wave), reach);
  }
  for (const auto& q : builder.motors())
    add_cyclic(builder, q,
               {.id = "cyclic_error",
                .subject = q,
                .where = "robot",
                .applies_to = AppliesTo::robot,
                .parameter = "period_nm",
                .scale = ParameterScale::inverse,
                .outputs = {q}},
               reach, longest_of_its_own(builder));
  if (builder.axes().empty() && builder.motors().empty())
    builder.missing("cyclic_error", "no motor or pose coordinate varies");
  if (!reach.empty()) {
    std::string all;
    for (const auto& one : reach) all += (all.empty() ? "" : "; ") + one;
    builder.missing("cyclic_error", all);
  }
  bool any_tilt = false;
  // The same tilts stand behind several axes where all outputs are asked: one cause, its axis is
  // told from the outputs afterwards.
  if (builder.lengths().size() == 1) {
    const auto& axis = builder.lengths().front();
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
  for (const auto& axis : builder.lengths()) add_turned(builder, axis);
  if (!any_tilt)
    for (const char* id : {"abbe_offset", "cosine_error"})
      builder.missing(id, "no tilt channel rx, ry, rz that varies");

  Cause air{.id = "refractive_index",
            .subject = builder.lengths().size() == 1 ? builder.lengths().front() : "",
            .where = "environment",
            .applies_to = AppliesTo::correction,
            .linear = LinearParameter::dead_path_mm};
  // An instrument that is told the air's temperature but not its pressure takes out a part of the
  // index, so the parts are tried as well as the whole; on the dead path, on the way measured, on
  // both.
  const auto on_the_path = [&](const std::vector<Term>& parts) {
    builder.add_terms(air, parts, kMissing);
    for (const auto& axis : builder.lengths()) {
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
