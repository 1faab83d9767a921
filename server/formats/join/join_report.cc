#include "server/formats/join/join_report.h"

#include <algorithm>

#include "server/core/data/dataset_parts.h"
#include "server/core/data/measured_by.h"
#include "server/core/data/overruns.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using correction::JoinedChannel;
using Json = nlohmann::ordered_json;

Json check_json(const JoinedChannel& joined) {
  const auto unit = summary_unit(joined.channel.unit);
  const auto& check = *joined.check;
  return Json{{"first", check.first},
              {"second", check.second},
              {"rows", check.rows},
              {"median_" + unit.unit, unit.factor * check.median},
              {"sigma_" + unit.unit, unit.factor * check.sigma},
              {"largest_" + unit.unit, unit.factor * check.largest},
              {"largest_row", check.largest_row + 1}};
}

Json channel_json(const JoinedChannel& joined) {
  const auto unit = summary_unit(joined.channel.unit);
  Json json{{"channel", joined.channel.name()}, {"sources", joined.sources}, {"unit", unit.unit}};
  if (joined.u) json["u_" + unit.unit] = unit.factor * *joined.u;
  if (joined.check) json["check"] = check_json(joined);
  return json;
}

std::string source_text(const JoinedChannel& joined) {
  const auto unit = summary_unit(joined.channel.unit);
  std::string text = joined.sources.size() > 1 ? "mean of " : "";
  for (std::size_t i = 0; i < joined.sources.size(); ++i)
    text += (i ? ", " : "") + joined.sources[i];
  if (joined.u) text += "; u " + quantity_text(unit.factor * *joined.u, unit.unit);
  if (joined.check)
    text += "; difference " + quantity_text(unit.factor * joined.check->median, unit.unit) +
            ", sigma " + quantity_text(unit.factor * joined.check->sigma, unit.unit);
  return text;
}

std::string value_of(const Dataset& data, std::string_view key) {
  for (const auto& [found, value] : data.metadata)
    if (found == key) return value;
  return {};
}

// Of the joined coordinates; of several sources the mean of all their instruments. Left out where a
// source does not state its own, or several sources had more than one each.
std::vector<MeasuredBy> instruments_of(const correction::JoinParts& parts,
                                       const correction::JoinReport& report) {
  std::vector<MeasuredBy> out;
  for (const auto& joined : report.channels) {
    MeasuredBy coordinate{joined.channel.symbol, {}};
    for (const auto& source : joined.sources) {
      const auto part = std::ranges::find(parts, source, &correction::JoinPart::name);
      if (part == parts.end()) break;
      const auto stated = measured_by_from(part->data.metadata);
      const auto* of_part = find_measured_by(stated, joined.channel.symbol);
      if (of_part == nullptr) break;
      if (joined.sources.size() == 1) {
        coordinate.parts = of_part->parts;
        break;
      }
      if (of_part->parts.size() != 1 || of_part->parts.front().devices.size() != 1) break;
      if (coordinate.parts.empty()) coordinate.parts.emplace_back();
      coordinate.parts.front().devices.push_back(of_part->parts.front().devices.front());
    }
    const bool whole = !coordinate.parts.empty() &&
                       (joined.sources.size() == 1 ||
                        coordinate.parts.front().devices.size() == joined.sources.size());
    if (whole) out.push_back(std::move(coordinate));
  }
  return out;
}

}  // namespace

Json join_json(const correction::JoinParts& parts, const correction::JoinRules& rules,
               const correction::JoinReport& report) {
  Json json{{"schema", "driftwise.join.v1"}, {"parts", Json::array()}};
  for (const auto& part : parts) {
    Json one{{"name", part.name},
             {"rows", part.data.rows},
             {"hash", part.hash},
             {"tool", part.tool},
             {"model", part.model}};
    for (const CorrectionId id : part.corrections) one["corrections"].push_back(id.value);
    json["parts"].push_back(std::move(one));
  }
  json["rules"] = {{"subtract_returns", rules.subtract_returns},
                   {"max_temperature_difference_k", rules.max_temperature_difference_k},
                   {"max_zero_difference_nm", nm_from_mm(rules.max_zero_difference_mm)}};
  json["rows"] = report.rows;
  json["unmatched_rows"] = report.unmatched_rows;
  if (report.temperature_difference_k) {
    json["temperature_difference_k"] = *report.temperature_difference_k;
    json["temperature_channel"] = report.temperature_channel;
  }
  if (report.zero_difference_mm)
    json["zero_difference_nm"] = nm_from_mm(*report.zero_difference_mm);
  json["channels"] = Json::array();
  for (const auto& joined : report.channels) json["channels"].push_back(channel_json(joined));
  json["warnings"] = report.warnings;
  return json;
}

std::vector<std::pair<std::string, std::string>> join_metadata(
    const correction::JoinParts& parts, const correction::JoinRules& rules,
    const correction::JoinReport& report) {
  std::vector<std::pair<std::string, std::string>> lines;
  for (const auto& part : parts)
    lines.emplace_back("joined", part.name + " (sha256 " + part.hash + ")");
  if (rules.subtract_returns) lines.emplace_back("join_returns", "subtracted");
  for (const auto& joined : report.channels)
    if (is_pose_symbol(joined.channel.symbol))
      lines.emplace_back("join_" + joined.channel.name(), source_text(joined));
  for (const auto& part : parts)
    if (!part.tool.empty()) {
      lines.emplace_back("tool", part.tool);
      break;
    }
  // The times and the path are those of the first part.
  for (const char* key : {"time_zero", kOverruns})
    if (const auto value = value_of(parts.front().data, key); !value.empty())
      lines.emplace_back(key, value);
  Parts places;
  for (const auto& part : parts)
    for (const auto& place : parts_from(part.data.metadata))
      if (std::ranges::find(places, place.first, &Parts::value_type::first) == places.end())
        places.push_back(place);
  if (!places.empty()) lines.emplace_back(kPartsKey, parts_text(places));
  if (const auto instruments = measured_by_text(instruments_of(parts, report));
      !instruments.empty())
    lines.emplace_back(kMeasuredByKey, instruments);
  return lines;
}

Result<correction::JoinPart> read_join_part(std::string_view csv, const std::string& file_name) {
  correction::JoinPart part;
  DRIFTWISE_TRY(part.data, read_dataset_csv(csv, file_name));
  part.name = file_name;
  part.hash = content_hash(csv);
  part.tool = value_of(part.data, "tool");
  const std::string compensation = value_of(part.data, "compensation");
  constexpr std::string_view kWith = " with ";
  if (const auto with = compensation.find(kWith); with != std::string::npos)
    part.model = compensation.substr(with + kWith.size());
  return part;
}

}  // namespace driftwise::formats
