// What the robot's own motion leaves behind: play, creep, heat.

#include <algorithm>
#include <cmath>

#include "server/core/units.h"
#include "server/diagnosis/catalogue/catalogue_builder.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

using effects::AppliesTo;
using effects::Term;

constexpr double kWidestPlayNm = 1e5, kNarrowestPlayNm = 10;
constexpr double kNarrowestPlay = 0.01;  // of a quarter of the stroke
// 10 nm and 100 um at a radius of 1 m and of 0.2 m.
constexpr double kWidestPlay_arcsec = 100, kNarrowestPlay_arcsec = 0.002;
// A screw winds up by the friction between its nut and the bearing that holds it, so that what is
// lost at a reversal grows along it (ISO 230-2 has the reversal value at each position). Prior
// probability beside that of a play which is the same all along.
constexpr double kUnevenPlay = 0.2;
// Correlation of a coordinate with the motor that moves it alone.
constexpr double kMovesAlone = 0.99;

Cause of_motor(const std::string& id, const std::string& q, const std::string& parameter) {
  return {.id = id,
          .subject = q,
          .where = "robot",
          .applies_to = AppliesTo::robot,
          .parameter = parameter,
          .scale = ParameterScale::logarithmic};
}

// Full widths of a play over a coordinate, from what a short stage has to a quarter of the way.
std::vector<double> widths_of_play(const CatalogueBuilder& builder, const std::string& symbol) {
  const bool angle = builder.is_angle(symbol);
  const double widest = angle ? kWidestPlay_arcsec : kWidestPlayNm;
  const double quarter = (angle ? builder.range(symbol) : nm_from_mm(builder.range(symbol))) / 4;
  // A stage of a hundred nanometres has a play of less than one.
  const double narrowest =
      std::min(angle ? kNarrowestPlay_arcsec : kNarrowestPlayNm, kNarrowestPlay * quarter);
  return log_grid(narrowest, std::clamp(quarter, 2 * narrowest, widest));
}

// Does one motor move the coordinate, and it alone? By their correlation over the rows.
bool moves_with_a_motor(const CatalogueBuilder& builder, const std::string& axis) {
  return std::ranges::any_of(builder.motors(), [&](const std::string& q) {
    const auto line = straight_line(builder.data().values_of(q), builder.data().values_of(axis));
    return std::abs(line.correlation) > kMovesAlone;
  });
}

std::vector<double> every(std::size_t step, const std::vector<double>& values) {
  std::vector<double> some;
  for (std::size_t i = 0; i < values.size(); i += step) some.push_back(values[i]);
  return some;
}

}  // namespace

// Losses of bearings and motors grow with a power of the speed or current between the first and the
// second (Palmgren; copper's with the square of the current).
void add_activities(CatalogueBuilder& builder) {
  if (builder.activities().empty())
    builder.missing("activity_heating", "no channel of an activity (rpm, Hz, A, W, V, pct) varies");
  else if (!builder.timed())
    builder.missing("activity_heating", "the data have no time_s");
  else
    for (const auto& of : builder.activities()) {
      Cause heat{.id = "activity_heating",
                 .subject = of,
                 .where = "robot",
                 .applies_to = AppliesTo::robot,
                 .parameter = "tau_s",
                 .scale = ParameterScale::logarithmic};
      for (const char* losses : {"lag", "square_lag"})
        builder.add_values(heat,
                           log_grid(std::max(4 * builder.step_s(), 1.0), builder.length_s() / 2),
                           [&](double tau) {
                             return std::vector<Term>{call_term(losses, {of}, {{tau, "s"}})};
                           });
      builder.take_cause(std::move(heat));
    }
}

// Dry friction holds a touching instrument back by half the width on the side that it came from.
// Along a coordinate that one motor moves alone it looks like that motor's play.
void add_probes(CatalogueBuilder& builder) {
  for (const auto& axis : builder.lengths()) {
    if (moves_with_a_motor(builder, axis)) continue;
    Cause drags{.id = "probe_hysteresis",
                .subject = axis,
                .where = "instrument",
                .applies_to = AppliesTo::correction,
                .parameter = "width_nm",
                .scale = ParameterScale::logarithmic};
    builder.add_values(drags, widths_of_play(builder, axis), [&](double width) {
      return std::vector<Term>{call_term("play", {axis}, {{width, "nm"}})};
    });
    builder.take_cause(std::move(drags));
  }
}

void add_motion(CatalogueBuilder& builder) {
  if (builder.motors().empty()) {
    for (const char* id : {"backlash", "creep", "self_heating"})
      builder.missing(id, "no motor coordinate (q1, q2, ...) varies");
    return;
  }
  const bool dwells = builder.timed() && builder.varies("dwell");
  for (const auto& q : builder.motors()) {
    const bool angle = builder.is_angle(q);
    const char* unit = angle ? "arcsec" : "nm";
    Cause play = of_motor("backlash", q, angle ? "width_arcsec" : "width_nm");
    play.linear = angle ? LinearParameter::width_arcsec : LinearParameter::width_nm;
    play.outputs = {q};
    const auto widths = widths_of_play(builder, q);
    const auto play_of = [&](double width) { return call_term("play", {q}, {{width, unit}}); };
    builder.add_values(play, widths,
                       [&](double width) { return std::vector<Term>{play_of(width)}; });
    const std::size_t even = play.cells.size();
    if (!angle)
      for (const auto& axis : builder.axes())
        builder.add_values(play, every(builder.axes().size(), widths), [&](double width) {
          return std::vector<Term>{effects::product(power_term(axis), play_of(width))};
        });
    for (std::size_t c = even; c < play.cells.size(); ++c) play.cells[c].weight = kUnevenPlay;
    builder.take_cause(std::move(play));
    if (!builder.timed()) continue;
    Cause heat = of_motor("self_heating", q, "tau_s");
    builder.add_values(heat, log_grid(std::max(4 * builder.step_s(), 1.0), builder.length_s() / 2),
                       [&](double tau) {
                         return std::vector<Term>{call_term("heat", {q}, {{tau, "s"}})};
                       });
    builder.take_cause(std::move(heat));
    Cause creep = of_motor("creep", q, "tau_s");
    creep.outputs = {q};
    builder.add_values(
        creep,
        log_grid(std::max(0.2 * builder.step_s(), 0.1),
                 std::min(builder.length_s() / 2, 200 * builder.step_s())),
        [&](double tau) {
          return std::vector<Term>{
              call_term("creep", dwells ? std::vector{q, std::string("dwell")} : std::vector{q},
                        {{tau, "s"}})};
        });
    builder.take_cause(std::move(creep));
  }
  if (!builder.timed())
    for (const char* id : {"self_heating", "creep"}) builder.missing(id, "the data have no time_s");
}

}  // namespace driftwise::diagnosis
