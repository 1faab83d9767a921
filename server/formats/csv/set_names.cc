#include "server/formats/csv/set_names.h"

#include <algorithm>
#include <charconv>

#include "server/core/try.h"
#include "server/formats/csv/csv_text.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

// The words of one column, and where in the text each stands.
struct SetWords {
  std::vector<std::string_view> words;  // views into the text
};

bool is_set_blank(char c) { return c == ' ' || c == '\t'; }

Result<SetWords> words_of(std::string_view text, const std::string& file_name) {
  DRIFTWISE_TRY(const auto header, read_csv_header(text, file_name));
  SetWords out;
  const auto column = std::ranges::find(header.names, "set");
  if (column == header.names.end()) return out;
  const auto index = column - header.names.begin();
  std::string_view rest = header.rows;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty()) continue;
    for (std::ptrdiff_t k = 0; k < index; ++k)
      line.remove_prefix(std::min(line.find(',', 0) + 1, line.size()));
    line = line.substr(0, line.find(','));
    while (!line.empty() && is_set_blank(line.front())) line.remove_prefix(1);
    while (!line.empty() && is_set_blank(line.back())) line.remove_suffix(1);
    out.words.push_back(line);
  }
  return out;
}

}  // namespace

bool is_set_name(std::string_view word) {
  constexpr std::size_t kMostBytes = 32;
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  if (word == "calibration" || word == "validation") return true;
  if (word.empty() || word.size() > kMostBytes || !is_letter(word.front())) return false;
  for (const char c : word)
    if (!is_letter(c) && !(c >= '0' && c <= '9') && c != '-' && c != '_') return false;
  std::string lower(word);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (lower.starts_with("cal") || lower.starts_with("kal")) return false;
  return lower.starts_with("validation") ||
         nearest_word(lower, {"calibration", "validation"}).empty();
}

Result<std::vector<std::string>> read_set_names(std::string_view text,
                                                const std::string& file_name) {
  DRIFTWISE_TRY(const auto found, words_of(text, file_name));
  std::vector<std::string> names;
  for (const auto word : found.words) {
    if (!is_set_name(word))
      return fail(ErrorCode::invalid_argument, reasons::kBadSet,
                  file_name + ": column set: found '" + std::string(word.substr(0, 40)) +
                      "', expected " + kSetNameExpected);
    names.emplace_back(word);
  }
  return names;
}

std::string with_set_names(std::string_view text, const std::vector<std::string>& names) {
  const auto found = words_of(text, "dataset");
  if (!found || found->words.size() != names.size()) return std::string(text);
  std::string out;
  out.reserve(text.size() + 8 * names.size());
  const char* at = text.data();
  for (std::size_t row = 0; row < names.size(); ++row) {
    const auto word = found->words[row];
    out.append(at, word.data());
    out += names[row];
    at = word.data() + word.size();
  }
  out.append(at, text.data() + text.size());
  return out;
}

std::string packed_set_names(const std::vector<std::string>& names) {
  std::string line;
  for (std::size_t first = 0; first < names.size();) {
    std::size_t end = first + 1;
    while (end < names.size() && names[end] == names[first]) ++end;
    line += (line.empty() ? "" : " ") + names[first] + "*" + std::to_string(end - first);
    first = end;
  }
  return line;
}

std::vector<std::string> unpacked_set_names(std::string_view line, std::size_t rows) {
  std::vector<std::string> names;
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(' '), line.size());
    const std::string_view item = line.substr(0, end);
    line.remove_prefix(std::min(end + 1, line.size()));
    const std::size_t star = item.find('*');
    std::size_t count = 0;
    if (star == std::string_view::npos || !is_set_name(item.substr(0, star))) return {};
    const char* last = item.data() + item.size();
    const auto [after, error] = std::from_chars(item.data() + star + 1, last, count);
    if (error != std::errc() || after != last || count > rows - names.size()) return {};
    names.insert(names.end(), count, std::string(item.substr(0, star)));
  }
  if (names.size() != rows) names.clear();
  return names;
}

std::vector<std::string> named_sets(const std::vector<std::string>& names) {
  std::vector<std::string> sets;
  for (const auto& name : names)
    if (name != "calibration" && name != "validation" &&
        std::ranges::find(sets, name) == sets.end())
      sets.push_back(name);
  return sets;
}

}  // namespace driftwise::formats
