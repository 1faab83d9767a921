#include "server/formats/cell_file/cell_file_closure.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"
#include "server/formats/text/toml_reader.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

void read_section(TomlReader&& reader, ClosureRules& out) {
  std::string unexplained = "new-datum";
  reader.choice("unexplained", unexplained, {"new-datum", "mark", "repeat"}, Need::optional);
  out.unexplained = unexplained == "mark"     ? UnexplainedClosure::mark
                    : unexplained == "repeat" ? UnexplainedClosure::repeat
                                              : UnexplainedClosure::new_datum;
  reader.integer("repeats", out.repeats, 1, 100);
  reader.finish();
}

void read_limit_of_closure(TomlReader&& reader, const CellDescription& cell, ClosureRules& out) {
  ClosureLimitDescription limit;
  Channel channel;
  reader.robot_channel("channel", channel, Need::required);
  limit.channel = channel.name();
  const bool angle = is_angle(channel.unit);
  constexpr Range kPositive{.min = 0, .max = 1e9, .above_min = true};
  reader.number(angle ? "limit_arcsec" : "limit_nm", limit.limit, kPositive, Need::required);
  auto known = cell.length_channels();
  const auto angles = cell.angle_channels();
  known.insert(known.end(), angles.begin(), angles.end());
  if (std::ranges::find(known, limit.channel, &Channel::name) == known.end()) {
    std::string names;
    for (const auto& one : known) names += (names.empty() ? "" : ", ") + one.name();
    reader.refuse(
        "channel", reasons::kBadChannel,
        "found " + shown(limit.channel) + ", expected a length or rotation of this cell: " + names);
  }
  if (std::ranges::find(out.limits, limit.channel, &ClosureLimitDescription::channel) !=
      out.limits.end())
    reader.refuse(
        "channel", reasons::kDuplicateChannel,
        "found " + shown(limit.channel) + ", which another [[closure_limit]] has already");
  reader.finish();
  out.limits.push_back(std::move(limit));
}

}  // namespace

ClosureRules read_closure(TomlReader& top, const CellDescription& cell, TomlProblem& problem) {
  ClosureRules rules;
  if (const auto* table = top.table("closure"))
    read_section(TomlReader(*table, "closure", problem), rules);
  for (const auto* table : top.tables("closure_limit")) {
    const std::string place = "closure_limit " + std::to_string(rules.limits.size() + 1);
    read_limit_of_closure(TomlReader(*table, place, problem), cell, rules);
  }
  return rules;
}

ClosureRules closure_rules_of(const CellDescription& cell) {
  try {
    TomlProblem problem{.file_name = cell.name, .first = {}};
    const auto root = parse_toml(cell.text);
    TomlReader top(root, "", problem);
    return read_closure(top, cell, problem);
  } catch (const toml::parse_error&) {  // it was not made from a cell file
    return {};
  }
}

}  // namespace driftwise::formats
