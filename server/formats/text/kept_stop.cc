#include "server/formats/text/kept_stop.h"

#include <nlohmann/json.hpp>

#include "server/core/text/clean_text.h"

namespace driftwise::formats {
namespace {

constexpr std::size_t kLongest = 200;  // bytes of a name or an instant

std::string text_or(const nlohmann::json& json, const char* key, const char* otherwise) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_string()) return otherwise;
  const std::string text = clean_line(json[key].get<std::string>());
  return text.empty() || text.size() > kLongest ? otherwise : text;
}

}  // namespace

std::string write_kept_stop(const KeptStop& stop) {
  const nlohmann::ordered_json json = {
      {"schema", "driftwise.stop.v1"}, {"who", stop.who}, {"asked", stop.asked}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

KeptStop read_kept_stop(std::string_view text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  return {text_or(json, "who", "somebody"), text_or(json, "asked", "an unknown instant")};
}

}  // namespace driftwise::formats
