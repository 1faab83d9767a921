#include "server/formats/import/mapping_file.h"

#include <algorithm>
#include <map>
#include <set>

#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/set_names.h"
#include "server/formats/import/mapping_poses.h"
#include "server/formats/text/text.h"
#include "server/formats/text/toml_reader.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

constexpr int kMostColumns = 100000;

void read_source(TomlReader& reader, const char* key, SourceColumn& out, Need need) {
  reader.text_or_integer(key, out.name, out.number, 1, kMostColumns, need);
}

// One character that cannot be part of a number's digits.
void read_mark(TomlReader& reader, const char* key, char& out, std::string_view not_these) {
  std::string text(1, out);
  if (!reader.has(key)) return reader.text(key, text);
  reader.text(key, text);
  if (text.size() == 1 && not_these.find(text[0]) == std::string_view::npos && text[0] > ' ' &&
      text[0] < 127 && text.find_first_of("0123456789eE+-\"") == std::string::npos)
    out = text[0];
  else
    reader.refuse(key, reasons::kOutOfRange,
                  "found " + shown(text) + ", expected one mark of its own such as \",\"");
}

void read_separator(TomlReader& file, TableLayout& out) {
  std::string text(1, out.separator);
  file.text("separator", text);
  if (text == "tab") text = "\t";
  out.blanks_separate = text == "blanks";
  if (out.blanks_separate) return;
  if (text.size() == 1 && std::string_view("\r\n\"+-.").find(text[0]) == std::string_view::npos &&
      !(text[0] >= '0' && text[0] <= '9'))
    out.separator = text[0];
  else
    file.refuse("separator", reasons::kOutOfRange,
                "found " + shown(text) + ", expected one character, tab or blanks");
}

void read_file_rules(TomlReader&& file, FileRules& out) {
  read_separator(file, out.layout);
  read_mark(file, "decimal", out.numbers.decimal, "");
  read_mark(file, "thousands", out.numbers.thousands, std::string(1, out.numbers.decimal));
  file.truth("header", out.header);
  file.truth("quotes", out.layout.quotes);
  file.text("comment", out.layout.comment);
  file.integer("skip_lines", out.layout.skip_lines, 0, 1000000);
  file.texts("missing", out.missing);
  std::string encoding = "utf-8";
  file.choice("encoding", encoding, {"utf-8", "latin-1", "utf-16-le", "utf-16-be"}, Need::optional);
  out.encoding = encoding == "latin-1"     ? TextEncoding::latin_1
                 : encoding == "utf-16-le" ? TextEncoding::utf_16_le
                 : encoding == "utf-16-be" ? TextEncoding::utf_16_be
                                           : TextEncoding::utf_8;
  if (!out.layout.blanks_separate && out.layout.separator == out.numbers.decimal)
    file.refuse("separator", reasons::kBadRule,
                "found the decimal mark, expected another character");
  file.finish();
}

void read_time(TomlReader&& reader, std::optional<TimeRules>& out) {
  TimeRules time;
  SourceColumn one;
  read_source(reader, "column", one, Need::optional);
  std::vector<std::string> names;
  reader.texts("columns", names);
  if (one.given()) time.columns.push_back(one);
  for (auto& name : names) time.columns.push_back({std::move(name), 0});
  if (one.given() == !names.empty())
    reader.refuse("column", reasons::kMissingKey, "expected column, or columns with several names");
  std::string format = "iso8601", order = "as-it-is", equal = "refuse";
  double utc_offset_h = 0;
  reader.text("format", format, Need::required);
  reader.number("utc_offset_h", utc_offset_h, {.min = -14, .max = 14});
  reader.choice("order", order, {"as-it-is", "by-time"}, Need::optional);
  reader.choice("equal_times", equal, {"refuse", "spread"}, Need::optional);
  reader.number("resolution_s", time.resolution_s, {.min = 0, .max = 86400, .above_min = true});
  time.order = order == "by-time" ? RowOrder::by_time : RowOrder::as_it_is;
  time.equal = equal == "spread" ? EqualTimes::spread : EqualTimes::refuse;
  auto parsed = TimeFormat::parse(format, utc_offset_h);
  if (parsed)
    time.format = std::move(*parsed);
  else
    reader.refuse("format", reasons::kBadTimeFormat, parsed.error().message);
  reader.finish();
  out = std::move(time);
}

// line, run, datum, zero and dwell_s are the dataset's own columns; everything else is a channel.
void read_target(TomlReader& reader, ColumnRule& out) {
  using RuleTarget = ColumnRule::Target;
  std::string name;
  reader.text("channel", name, Need::required);
  if (name.empty()) return;
  if (name == "line") out.target = RuleTarget::line;
  if (name == "run") out.target = RuleTarget::run;
  if (name == "datum") out.target = RuleTarget::datum;
  if (name == "zero") out.target = RuleTarget::zero;
  if (name == "dwell_s") out.target = RuleTarget::dwell;
  if (name == "set" || name == "time_s")
    return reader.refuse("channel", reasons::kBadChannel,
                         "found " + shown(name) + ", which the mapping's [" +
                             (name == "set" ? "sets" : "time") + "] table is for");
  if (out.target == RuleTarget::dwell) out.channel = {"dwell", "s"};
  if (out.target != RuleTarget::channel) return;
  auto channel = parse_robot_channel(name);
  if (!channel) return reader.refuse("channel", reasons::kBadChannel, channel.error().message);
  out.channel = std::move(*channel);
}

void read_column(TomlReader&& reader, ColumnRule& out) {
  read_source(reader, "source", out.source, Need::required);
  read_target(reader, out);
  reader.text("unit", out.unit);
  reader.number("scale", out.scale);
  reader.number("offset", out.offset);
  reader.truth("required", out.required);
  if (out.unit.empty()) out.unit = out.channel.unit;
  if (!out.unit.empty() && !out.channel.unit.empty()) {
    auto convert = unit_conversion(out.unit, out.channel.unit);
    if (convert)
      out.convert =
          out.is_spread() ? UnitConversion{convert->factor, convert->divisor, 0} : *convert;
    else
      reader.refuse(
          "unit",
          convert.error().reason == reasons::kUnitKind ? reasons::kUnitKind : reasons::kUnknownUnit,
          convert.error().message);
  }
  if (out.scale == 0)
    reader.refuse("scale", reasons::kOutOfRange,
                  "found 0, expected another factor: all would be equal");
  reader.finish();
}

void read_drop(TomlReader&& reader, DropRule& out) {
  read_source(reader, "column", out.source, Need::required);
  double below = kMissing, above = kMissing;
  std::string equals;
  reader.truth("missing", out.missing);
  reader.number("below", below);
  reader.number("above", above);
  reader.text("equals", equals);
  reader.text("why", out.why, Need::required);
  if (!is_missing(below)) out.below = below;
  if (!is_missing(above)) out.above = above;
  if (reader.has("equals")) out.equals = equals;
  if (!out.missing && !out.below && !out.above && !out.equals)
    reader.refuse("column", reasons::kBadRule, "expected missing = true, below, above or equals");
  reader.finish();
}

void read_group(TomlReader&& reader, std::optional<GroupRule>& out) {
  GroupRule group;
  std::string into = "line";
  reader.texts("channels", group.channels, Need::required);
  reader.number("within", group.within, {.min = 0});
  reader.text("into", into);
  if (group.channels.empty())
    reader.refuse("channels", reasons::kOutOfRange, "found none, expected at least one channel");
  if (into != "line") {
    auto channel = parse_channel(into);
    if (channel && channel->unit == "1")
      group.channel = std::move(*channel);
    else
      reader.refuse("into", reasons::kBadChannel,
                    "found " + shown(into) +
                        ", expected line or a channel without a unit such as "
                        "goal_1");
  }
  reader.finish();
  out = std::move(group);
}

void read_sets(TomlReader&& reader, SetRule& out) {
  int every = 0, seed = 1;
  double share = 0;
  reader.integer("validation_every", every, 2, 1000000);
  reader.number("validation_share", share, {.min = 0, .max = 0.9, .above_min = true});
  reader.integer("seed", seed, 0, 2147483647);
  read_source(reader, "column", out.source, Need::optional);
  reader.texts("validation", out.validation);
  out.every = every;
  out.share = share;
  out.seed = static_cast<std::uint64_t>(seed);
  using By = SetRule::By;
  out.by = every > 0 ? By::every : share > 0 ? By::share : By::column;
  const int ways = (every > 0) + (share > 0) + out.source.given();
  if (ways != 1)
    reader.refuse("validation_every", reasons::kBadRule,
                  "expected one of validation_every, validation_share, or column with validation");
  if (out.source.given() == out.validation.empty())
    reader.refuse("validation", reasons::kBadRule,
                  "expected column and validation (the texts that mean validation) together");
  reader.finish();
}

// What each quantity of the dataset comes from stands once, in one unit: a dataset with x_mm and
// x_um is refused by its reader.
void check_channels(TomlProblem& problem, const toml::table& root, const ImportMapping& mapping) {
  std::map<std::string, std::string> by_symbol;
  std::set<std::string> taken;
  const auto take = [&](const std::string& name) {
    taken.insert(name);
    const auto channel = parse_robot_channel(name);
    const auto [before, fresh] = by_symbol.emplace(channel ? channel->symbol : name, name);
    if (!fresh)
      problem.add(ErrorCode::invalid_argument, reasons::kDuplicateChannel, root.source(),
                  "the channel " + shown(name) + " is given twice" +
                      (before->second == name ? "" : ", also as " + shown(before->second)));
  };
  using RuleTarget = ColumnRule::Target;
  for (const auto& column : mapping.columns) {
    if (column.target == RuleTarget::channel) take(column.channel.name());
    if (column.target == RuleTarget::line) take("line");
    if (column.target == RuleTarget::run) take("run");
    if (column.target == RuleTarget::datum) take("datum");
    if (column.target == RuleTarget::zero) take("zero");
    if (column.target == RuleTarget::dwell) take("dwell_s");
  }
  for (const auto& constant : mapping.constants) take(constant.channel.name());
  const auto expect = [&](const std::string& name, const char* table) {
    if (!taken.contains(name))
      problem.add(ErrorCode::invalid_argument, reasons::kBadChannel, root.source(),
                  std::string(table) + ": found " + shown(name) +
                      ", expected a channel that a [[column]] gives");
  };
  for (const auto& pose : mapping.poses) {
    for (const auto& name : pose.position) expect(name, "pose");
    for (const auto& name : pose.rotation) expect(name, "pose");
    for (const auto& name : pose.into_position)
      if (std::ranges::find(pose.position, name) == pose.position.end()) take(name);
    for (const auto& name : pose.into_rotation)
      if (std::ranges::find(pose.rotation, name) == pose.rotation.end()) take(name);
  }
  if (mapping.group) {
    for (const auto& name : mapping.group->channels) expect(name, "group");
    take(mapping.group->channel ? mapping.group->channel->name() : "line");
  }
}

void read_constants(TomlReader&& reader, const toml::table& table, ImportMapping& out) {
  for (const auto& [key, node] : table) {
    const char* name = key.str().data();  // of a std::string: it ends with a zero
    double value = 0;
    reader.number(name, value, {}, Need::required);
    auto channel = parse_robot_channel(name);
    if (channel)
      out.constants.push_back({std::move(*channel), value});
    else
      reader.refuse(name, reasons::kBadChannel, channel.error().message);
  }
}

template <class Rules>
std::string numbered_table(const char* table, const Rules& so_far) {
  return table + (" " + std::to_string(so_far.size()));
}

void read_mapping(const toml::table& root, ImportMapping& out, TomlProblem& problem) {
  TomlReader reader(root, "", problem);
  if (const auto* file = reader.table("file")) read_file_rules({*file, "file", problem}, out.file);
  if (const auto* time = reader.table("time")) read_time({*time, "time", problem}, out.time);
  for (const auto* table : reader.tables("column")) {
    ColumnRule& column = out.columns.emplace_back();
    read_column({*table, numbered_table("column", out.columns), problem}, column);
  }
  if (const auto* table = reader.table("constants"))
    read_constants({*table, "constants", problem}, *table, out);
  for (const auto* table : reader.tables("drop")) {
    DropRule& drop = out.drops.emplace_back();
    read_drop({*table, numbered_table("drop", out.drops), problem}, drop);
  }
  for (const auto* table : reader.tables("pose")) {
    PoseRule& pose = out.poses.emplace_back();
    read_pose(*table, numbered_table("pose", out.poses), problem, pose);
  }
  if (const auto* table = reader.table("group")) read_group({*table, "group", problem}, out.group);
  if (const auto* table = reader.table("sets")) read_sets({*table, "sets", problem}, out.sets);
  std::map<std::string, std::string> metadata;
  reader.strings("metadata", metadata);
  for (const auto key : {kDatasetVersionKey, kSetNamesKey})  // the writer's own lines
    if (metadata.contains(std::string(key)))
      reader.refuse("metadata", reasons::kBadRule,
                    "found the key " + std::string(key) +
                        ", expected keys that say nothing of the dataset's format");
  out.metadata.assign(metadata.begin(), metadata.end());
  reader.finish();
  if (out.columns.empty())
    problem.add(ErrorCode::invalid_argument, reasons::kNoColumns, root.source(),
                "found no [[column]], expected one per channel");
  if (!problem.any()) check_channels(problem, root, out);
}

}  // namespace

Result<ImportMapping> read_import_mapping(std::string_view text, const std::string& file_name) {
  TomlProblem problem{file_name, {}};
  ImportMapping out;
  out.name = file_name;
  out.hash = content_hash(text);
  try {
    read_mapping(parse_toml(text, file_name), out, problem);
  } catch (const toml::parse_error& error) {
    return tl::unexpected(syntax_error(error, file_name));
  }
  if (problem.any()) return tl::unexpected(*problem.first);
  return out;
}

}  // namespace driftwise::formats
