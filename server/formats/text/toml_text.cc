#include "server/formats/text/toml_text.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace driftwise::formats {
namespace {

// Levels of the place that the reading has come to. It agrees with toml++ about strings, comments
// and lines up to the first syntax error; toml++ reads no further.
class TomlLevels {
 public:
  explicit TomlLevels(std::string_view text) : text_(text) {}

  std::optional<toml::source_position> too_deep() {
    while (at_ < text_.size()) {
      const std::size_t before = at_;
      read_one();
      if (header_ + in_brackets_ + dots_ + 1 > kMostTomlLevels) return position_of(before);
    }
    return std::nullopt;
  }

 private:
  void read_one() {
    const char c = text_[at_];
    if (c == '"' || c == '\'') return skip_string(c);
    if (c == '#') return skip_comment();
    ++at_;
    if (c == '.') ++dots_;  // of a number, too: one level more than there is
    if (c == ',') dots_ = 0;
    if (c == '=') has_value_ = true;
    if (c == '\n') end_line();
    if (c == '[' || c == '{') open();
    if (c == ']' || c == '}') close();
  }

  // No key and no header goes on in the next line.
  void end_line() {
    if (is_header_) header_ = dots_ + 1;
    is_header_ = false;
    dots_ = 0;
    if (brackets_.empty()) has_value_ = false;
  }

  void open() {
    if (brackets_.empty() && !has_value_) {  // [header] and [[header]]
      is_header_ = true;
      header_ = 0;
      return;
    }
    brackets_.push_back(dots_ + 1);
    in_brackets_ += dots_ + 1;
    dots_ = 0;
  }

  void close() {
    if (brackets_.empty()) return;
    in_brackets_ -= brackets_.back();
    brackets_.pop_back();
    dots_ = 0;
  }

  void skip_comment() { at_ = std::min(text_.find('\n', at_), text_.size()); }

  void skip_string(char quote) {
    const std::string three(3, quote);
    const bool is_long = text_.substr(at_).starts_with(three);
    at_ += is_long ? 3 : 1;
    while (at_ < text_.size()) {
      if (quote == '"' && text_[at_] == '\\') {
        at_ = std::min(at_ + 2, text_.size());
      } else if (!is_long && (text_[at_] == quote || text_[at_] == '\n')) {
        if (text_[at_] == quote) ++at_;
        return;
      } else if (is_long && text_.substr(at_).starts_with(three)) {
        // Two more quotes may belong to the string.
        for (int quotes = 0; quotes < 5 && at_ < text_.size() && text_[at_] == quote; ++quotes)
          ++at_;
        return;
      } else {
        ++at_;
      }
    }
  }

  toml::source_position position_of(std::size_t at) const {
    const auto before = text_.substr(0, at);
    const auto last = before.rfind('\n');
    const auto lines = std::ranges::count(before, '\n');
    return {
        static_cast<toml::source_index>(lines + 1),
        static_cast<toml::source_index>(at - (last == std::string_view::npos ? 0 : last + 1) + 1)};
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::vector<std::size_t> brackets_{};  // levels of each open one, with the key before it
  std::size_t header_ = 0, in_brackets_ = 0, dots_ = 0;
  bool is_header_ = false, has_value_ = false;
};

}  // namespace

toml::table parse_toml(std::string_view text, std::string_view file_name) {
  if (const auto where = TomlLevels(text).too_deep()) {
    const std::string sentence =
        "found keys, tables and lists more than " + std::to_string(kMostTomlLevels) +
        " levels inside one another, which no file of Driftwise has: take the dots or brackets out";
    throw toml::parse_error(sentence.c_str(), *where,
                            std::make_shared<const std::string>(file_name));
  }
  return toml::parse(text, file_name);
}

}  // namespace driftwise::formats
