#include "server/formats/text/json_place.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

tl::unexpected<Error> bad_json(std::string_view text, std::size_t at, const std::string& sentence) {
  const auto before = text.substr(0, at);
  const auto line = static_cast<std::size_t>(std::ranges::count(before, '\n')) + 1;
  const auto column =
      at - (before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1) + 1;
  return fail(
      ErrorCode::invalid_argument, reasons::kJsonSyntax,
      "line " + std::to_string(line) + ", column " + std::to_string(column) + ": " + sentence);
}

// Place of the bracket that opens one level too many.
std::optional<std::size_t> too_deep_in_json(std::string_view text) {
  std::size_t level = 0;
  bool is_string = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (is_string && c == '\\') ++at;
    if (c == '"') is_string = !is_string;
    if (is_string) continue;
    if ((c == '[' || c == '{') && ++level > kMostJsonLevels) return at;
    if ((c == ']' || c == '}') && level > 0) --level;
  }
  return std::nullopt;
}

template <class Json>
Result<Json> shallow_json(std::string_view text) {
  if (const auto at = too_deep_in_json(text))
    return bad_json(text, *at,
                    "found more than " + std::to_string(kMostJsonLevels) +
                        " lists and objects inside one another, expected fewer");
  try {
    return Json::parse(text);
  } catch (const typename Json::parse_error& error) {
    const std::size_t at = std::min(text.size(), error.byte > 0 ? error.byte - 1 : text.size());
    return bad_json(text, at,
                    "found " +
                        (at < text.size() ? shown(text.substr(at, 16)) : "the end of the text") +
                        ", expected JSON");
  } catch (const typename Json::out_of_range& error) {
    return bad_json(text, 0, std::string("found a number beyond doubles: ") + error.what());
  }
}

}  // namespace

JsonPlace JsonPlace::operator[](const char* key) const {
  if (!value_->is_object()) refuse("an object");
  const auto found = value_->find(key);
  const std::string place = place_.empty() ? key : place_ + "." + key;
  if (found == value_->end()) throw JsonProblem{place, "nothing", "this key"};
  return {*found, place};
}

JsonPlace JsonPlace::operator[](std::size_t index) const {
  return {(*value_)[index], place_ + "[" + std::to_string(index) + "]"};
}

bool JsonPlace::has(const char* key) const {
  if (!value_->is_object()) refuse("an object");
  const auto found = value_->find(key);
  return found != value_->end() && !found->is_null();
}

std::size_t JsonPlace::size() const {
  if (!value_->is_array()) refuse("an array");
  return value_->size();
}

std::string JsonPlace::text() const {
  if (!value_->is_string()) refuse("a string");
  return value_->get<std::string>();
}

bool JsonPlace::truth() const {
  if (!value_->is_boolean()) refuse("true or false");
  return value_->get<bool>();
}

std::int64_t JsonPlace::integer(std::int64_t min, std::int64_t max) const {
  const bool fits = value_->is_number_integer() &&
                    (!value_->is_number_unsigned() ||
                     value_->get<std::uint64_t>() <= static_cast<std::uint64_t>(INT64_MAX));
  if (!fits || value_->get<std::int64_t>() < min || value_->get<std::int64_t>() > max)
    refuse(min == INT64_MIN && max == INT64_MAX
               ? "a whole number"
               : "a whole number from " + std::to_string(min) + " to " + std::to_string(max));
  return value_->get<std::int64_t>();
}

double JsonPlace::finite() const {
  if (!value_->is_number() || !std::isfinite(value_->get<double>())) refuse("a finite number");
  return value_->get<double>();
}

double JsonPlace::number() const {
  if (value_->is_string()) {
    const auto word = value_->get<std::string>();
    if (word == "inf") return std::numeric_limits<double>::infinity();
    if (word == "-inf") return -std::numeric_limits<double>::infinity();
    if (word == "nan") return std::numeric_limits<double>::quiet_NaN();
  }
  if (!value_->is_number()) refuse("a number, \"inf\", \"-inf\" or \"nan\"");
  return value_->get<double>();
}

Channel JsonPlace::channel() const {
  auto channel = parse_robot_channel(text());
  if (!channel) refuse("a channel such as q1_mm");
  return std::move(*channel);
}

void JsonPlace::refuse(const std::string& expected) const {
  const std::string found =
      value_->is_array() || value_->is_object()
          ? std::string("an ") + value_->type_name() + " of " + std::to_string(value_->size())
          : shown(value_->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  throw JsonProblem{place_, found, expected};
}

nlohmann::ordered_json json_number(double value) {
  if (std::isfinite(value)) return value;
  if (std::isnan(value)) return "nan";
  return value > 0 ? "inf" : "-inf";
}

Result<nlohmann::json> parse_json(std::string_view text) {
  return shallow_json<nlohmann::json>(text);
}

Result<nlohmann::ordered_json> parse_ordered_json(std::string_view text) {
  return shallow_json<nlohmann::ordered_json>(text);
}

}  // namespace driftwise::formats
