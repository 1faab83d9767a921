#pragma once
// A JSON value together with where it stands, so that every complaint can name its place
// ("outputs[0].covariance"). Inside a reader complaints travel as the exception JsonProblem; the
// reader catches it and answers with the Error.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "server/core/channel.h"
#include "server/core/result.h"

namespace driftwise::formats {

struct JsonProblem {
  std::string place, found, expected;
};

class JsonPlace {
 public:
  JsonPlace(const nlohmann::json& value, std::string place)
      : value_(&value), place_(std::move(place)) {}

  JsonPlace operator[](const char* key) const;    // a member that must be there
  JsonPlace operator[](std::size_t index) const;  // an element; see size()
  bool has(const char* key) const;                // there and not null
  std::size_t size() const;                       // of an array

  std::string text() const;
  bool truth() const;
  std::int64_t integer(std::int64_t min = INT64_MIN, std::int64_t max = INT64_MAX) const;
  double finite() const;
  double number() const;  // or "inf", "-inf", "nan"
  Channel channel() const;

  [[noreturn]] void refuse(const std::string& expected) const;

 private:
  const nlohmann::json* value_;
  std::string place_;
};

// Infinities and NaN as text: JSON has no such numbers.
nlohmann::ordered_json json_number(double value);

// Errors: invalid_argument, JSON_SYNTAX, naming line and column.
Result<nlohmann::json> parse_json(std::string_view text);

}  // namespace driftwise::formats
