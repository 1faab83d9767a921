#pragma once
// Typed reading of one TOML table with errors that name file, line, field, what was found and what
// was expected.

#include <toml++/toml.h>

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace driftwise::simulated {

// Keys that nobody asked for are an error too: call finish() when all have been read.
class Fields {
 public:
  Fields(std::string file, std::string path, const toml::table& table)
      : file_(std::move(file)), path_(std::move(path)), table_(table) {}

  double number(std::string_view key);        // any finite number
  double positive(std::string_view key);      // > 0
  double not_negative(std::string_view key);  // >= 0
  double within(std::string_view key, double low, double high);
  int whole(std::string_view key, int low, int high);
  std::string text(std::string_view key);
  std::string text_or(std::string_view key, std::string_view fallback);
  std::vector<std::string> texts(std::string_view key);
  std::vector<double> numbers(std::string_view key, std::size_t count);
  std::vector<std::vector<double>> rows(std::string_view key, std::size_t width);
  bool has(std::string_view key) const { return table_.contains(key); }
  Fields table(std::string_view key);      // [path.key]
  std::vector<std::string> table_names();  // of all sub-tables
  void finish() const;

  // "file:line: path.key: " + what; throws PlantFileError.
  [[noreturn]] void fail(std::string_view key, std::string_view what) const;

 private:
  const toml::node& node(std::string_view key, std::string_view expected);
  [[noreturn]] void wrong(std::string_view key, const toml::node& found,
                          std::string_view expected) const;
  std::string place(const toml::node* found, std::string_view key) const;

  std::string file_, path_;
  const toml::table& table_;
  std::set<std::string, std::less<>> read_;
};

}  // namespace driftwise::simulated
