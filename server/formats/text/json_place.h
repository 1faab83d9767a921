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

// Ours have ten. nlohmann::json parses and destroys deeper texts in a loop, but copies and writes
// them by recursion, and ordered_json copies its members while it parses: 100 kB of brackets
// overflow the stack.
inline constexpr std::size_t kMostJsonLevels = 100;

// Errors: invalid_argument, JSON_SYNTAX, naming line and column; also for more than kMostJsonLevels
// lists and objects inside one another, and for a number beyond doubles.
Result<nlohmann::json> parse_json(std::string_view text);
// The same with the keys in the order of the text.
Result<nlohmann::ordered_json> parse_ordered_json(std::string_view text);

}  // namespace driftwise::formats
