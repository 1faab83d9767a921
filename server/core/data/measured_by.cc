#include "server/core/data/measured_by.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>

namespace driftwise {
namespace {

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> pieces;
  std::istringstream words(text);
  for (std::string piece; std::getline(words, piece, at);) pieces.push_back(piece);
  return pieces;
}

// "a+b*120"; no count: of all rows.
std::optional<MeasuredRows> rows_from(const std::string& text) {
  MeasuredRows part;
  const auto star = text.find('*');
  if (star != std::string::npos) {
    std::int64_t rows = 0;
    const char* const end = text.data() + text.size();
    const auto [stopped, problem] = std::from_chars(text.data() + star + 1, end, rows);
    if (problem != std::errc() || stopped != end || rows < 1) return std::nullopt;
    part.rows = static_cast<double>(rows);
  }
  part.devices = split(text.substr(0, star), '+');
  if (part.devices.empty() || std::ranges::find(part.devices, "") != part.devices.end())
    return std::nullopt;
  return part;
}

std::optional<MeasuredBy> coordinate_from(const std::string& word) {
  const auto equals = word.find('=');
  if (equals == std::string::npos || equals == 0) return std::nullopt;
  MeasuredBy out{word.substr(0, equals), {}};
  for (const auto& text : split(word.substr(equals + 1), ',')) {
    auto part = rows_from(text);
    if (!part) return std::nullopt;
    out.parts.push_back(std::move(*part));
  }
  if (out.parts.empty()) return std::nullopt;
  return out;
}

bool can_be_written(const MeasuredBy& coordinate) {
  for (const auto& part : coordinate.parts)
    for (const auto& device : part.devices)
      if (device.empty() || device.find_first_of(" \t\r\n=,+*") != std::string::npos) return false;
  return !coordinate.parts.empty();
}

}  // namespace

double MeasuredBy::weight(std::string_view device) const {
  double all = 0, of_it = 0;
  for (const auto& part : parts) {
    all += part.rows;
    of_it += part.rows * static_cast<double>(std::ranges::count(part.devices, device)) /
             static_cast<double>(part.devices.size());
  }
  return all > 0 ? of_it / all : 0;
}

std::vector<MeasuredBy> measured_by_from(
    const std::vector<std::pair<std::string, std::string>>& metadata) {
  std::vector<MeasuredBy> out;
  for (const auto& [key, value] : metadata) {
    if (key != kMeasuredByKey) continue;
    std::istringstream words(value);
    for (std::string word; words >> word;) {
      auto coordinate = coordinate_from(word);
      if (!coordinate) continue;
      std::erase_if(out, [&](const auto& one) { return one.symbol == coordinate->symbol; });
      out.push_back(std::move(*coordinate));
    }
  }
  return out;
}

std::string measured_by_text(const std::vector<MeasuredBy>& coordinates) {
  std::string text;
  for (const auto& coordinate : coordinates) {
    if (!can_be_written(coordinate)) continue;
    text += (text.empty() ? "" : " ") + coordinate.symbol + "=";
    for (std::size_t p = 0; p < coordinate.parts.size(); ++p) {
      const auto& part = coordinate.parts[p];
      for (std::size_t d = 0; d < part.devices.size(); ++d)
        text += (d > 0 ? "+" : p > 0 ? "," : "") + part.devices[d];
      if (coordinate.parts.size() > 1)
        text += "*" + std::to_string(static_cast<std::int64_t>(part.rows));
    }
  }
  return text;
}

const MeasuredBy* find_measured_by(const std::vector<MeasuredBy>& coordinates,
                                   std::string_view symbol) {
  const auto found = std::ranges::find(coordinates, symbol, &MeasuredBy::symbol);
  return found == coordinates.end() ? nullptr : &*found;
}

}  // namespace driftwise
