#pragma once
// Reads one TOML table key by key and remembers the first problem of the whole file, so that a
// parser reads like the list of its keys. Every message: file:line, the place and key, what was
// found, what was expected.

#include <toml++/toml.h>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/channel.h"
#include "server/core/devices/settings_reader.h"
#include "server/core/reasons.h"
#include "server/core/result.h"

namespace driftwise::formats {

// Shared by all tables of one file.
struct TomlProblem {
  std::string file_name;
  std::optional<Error> first;

  bool any() const { return first.has_value(); }
  void add(ErrorCode code, const std::string& reason, const toml::source_region& where,
           const std::string& sentence);
};

// TOML_SYNTAX with file:line and column; a decimal comma is named.
Error syntax_error(const toml::parse_error& error, const std::string& file_name);

class TomlReader {
 public:
  // place: "device 2, probe 3", "run"; empty for the top level.
  TomlReader(const toml::table& table, std::string place, TomlProblem& problem);

  // Each leaves its argument as it is when an optional key is absent or something was wrong.
  void text(const char* key, std::string& value, Need need = Need::optional);
  void choice(const char* key, std::string& value, std::span<const std::string_view> allowed,
              Need need);
  void choice(const char* key, std::string& value, std::initializer_list<std::string_view> allowed,
              Need need) {
    choice(key, value, std::span(allowed.begin(), allowed.size()), need);
  }
  void number(const char* key, double& value, Range range = {}, Need need = Need::optional);
  void integer(const char* key, int& value, int min, int max, Need need = Need::optional);
  void truth(const char* key, bool& value);
  // Three finite numbers, none larger than limit in size: [x, y, z].
  void vector3(const char* key, std::array<double, 3>& value, double limit);
  void time(const char* key,
            CellTime& value);  // "2011-07-22T08:00:00Z" as a string or a TOML date-time
  void channel(const char* key, Channel& value, Need need);
  // The same, or with a robot's id and a dot before it: mn.x_mm.
  void robot_channel(const char* key, Channel& value, Need need);
  // A list of texts; a single text is a list of one.
  void texts(const char* key, std::vector<std::string>& values, Need need = Need::optional);
  // A list of finite numbers, exactly count of them.
  void numbers(const char* key, std::vector<double>& values, std::size_t count);
  // A list of finite numbers, of any length.
  void numbers(const char* key, std::vector<double>& values);
  // Lists of numbers in a list: a matrix, row by row. Checks that all rows are of one length.
  void matrix(const char* key, std::vector<std::vector<double>>& rows);
  // A text that is no number, or a whole number from min to max.
  void text_or_integer(const char* key, std::string& text, int& number, int min, int max,
                       Need need = Need::optional);
  void strings(const char* key,
               std::map<std::string, std::string>& values);  // a table of plain values, as text

  // The tables behind a key: one for [key], each of them for [[key]].
  const toml::table* table(const char* key);
  std::vector<const toml::table*> tables(const char* key);

  // Every key that nobody asked for is unknown: UNKNOWN_KEY with the nearest known one.
  void finish();

  // A problem at this key's value (or at the table when the key is absent).
  void refuse(const char* key, Reason reason, const std::string& sentence,
              ErrorCode code = ErrorCode::invalid_argument);
  bool has(const char* key) const { return table_.contains(key); }
  std::size_t line() const { return table_.source().begin.line; }

 private:
  const toml::node* find(const char* key, Need need);
  void wrong_type(const char* key, const toml::node& node, const char* expected);
  bool read_numbers(const char* key, const toml::node& node, std::vector<double>& values);

  const toml::table& table_;
  std::string place_;
  TomlProblem& problem_;
  std::vector<std::string_view> known_;
};

}  // namespace driftwise::formats
