#include "server/formats/cell_file/cell_file_keep_outs.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

constexpr double kLongest_mm = 1e4;

void read_term(TomlReader&& reader, const CellDescription& cell, KeepOutDescription& rule) {
  KeepOutTerm term;
  reader.robot_channel("channel", term.axis, Need::required);
  reader.number("per_mm", term.per_mm, {.min = -1e3, .max = 1e3}, Need::required);
  const auto motors = cell.motor_channels();
  std::string known;
  for (const auto& motor : motors) known += (known.empty() ? "" : ", ") + motor.name();
  if (!term.axis.symbol.empty() && std::ranges::find(motors, term.axis) == motors.end())
    reader.refuse("channel", reasons::kBadKeepOut,
                  "found " + shown(term.axis.name()) + ", expected an axis of this cell: " + known);
  if (std::ranges::find(rule.terms, term.axis, &KeepOutTerm::axis) != rule.terms.end())
    reader.refuse("channel", reasons::kDuplicateChannel,
                  "found " + shown(term.axis.name()) + ", which this rule has already");
  if (reader.has("per_mm") && term.per_mm == 0)
    reader.refuse("per_mm", reasons::kBadKeepOut,
                  "found 0, expected the change of the distance per mm of " +
                      shown(term.axis.name()) + ", or no such axis in this rule");
  reader.finish();
  const std::string robot(robot_of(term.axis.symbol));
  if (std::ranges::find(rule.robots, robot) == rule.robots.end()) rule.robots.push_back(robot);
  rule.terms.push_back(std::move(term));
}

}  // namespace

void read_keep_out(TomlReader&& reader, const std::string& place, CellDescription& out,
                   TomlProblem& problem) {
  constexpr Range kDistance{.min = -kLongest_mm, .max = kLongest_mm};
  KeepOutDescription rule;
  reader.text("name", rule.name, Need::required);
  reader.number("min_mm", rule.min_mm, kDistance, Need::required);
  reader.number("at_zero_mm", rule.at_zero_mm, kDistance, Need::required);
  for (const auto* table : reader.tables("axis"))
    read_term(
        TomlReader(*table, place + ", axis " + std::to_string(rule.terms.size() + 1), problem), out,
        rule);
  if (rule.robots.size() < 2)
    reader.refuse("axis", reasons::kBadKeepOut,
                  std::string("found axes of ") + (rule.robots.empty() ? "no robot" : "one robot") +
                      ", expected [[keep_out.axis]] of two: it is a distance between them");
  if (rule.at_zero_mm < rule.min_mm)
    reader.refuse("at_zero_mm", reasons::kBadKeepOut,
                  "found " + number_text(rule.at_zero_mm) + ", expected at least min_mm = " +
                      number_text(rule.min_mm) + ": every run begins with all axes at 0");
  if (std::ranges::find(out.keep_outs, rule.name, &KeepOutDescription::name) != out.keep_outs.end())
    reader.refuse("name", reasons::kDuplicateId,
                  "found " + shown(rule.name) + ", which another [[keep_out]] has already");
  reader.finish();
  out.keep_outs.push_back(std::move(rule));
}

}  // namespace driftwise::formats
