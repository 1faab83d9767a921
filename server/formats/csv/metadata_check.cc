#include "server/formats/csv/metadata_check.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <vector>

#include "server/core/channel.h"
#include "server/core/data/dataset_parts.h"
#include "server/core/data/measured_by.h"
#include "server/core/data/overruns.h"
#include "server/core/reasons.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

constexpr std::array<std::string_view, 3> kPartNames = {"robot", "instrument", "air"};

// Line of the text, from 1, of an entry of the metadata: each is one line that begins with '#'.
std::size_t line_of_entry(std::string_view text, std::size_t entry) {
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size();) {
    ++line;
    std::string_view rest = text.substr(at);
    if (line == 1 && rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
    if (rest.starts_with('#') && entry-- == 0) return line;
    const auto end = text.find('\n', at);
    if (end == std::string_view::npos) break;
    at = end + 1;
  }
  return line;
}

std::string nearest_of(std::string_view found, const std::vector<std::string_view>& known) {
  const auto nearest = nearest_word(found, known);
  return nearest.empty() ? "" : ", did you mean " + nearest + "?";
}

// Empty: nothing is wrong with the word.
std::string wrong_with_part(const std::string& word, const Dataset& data, bool all_have_parts) {
  constexpr const char* kExpected =
      ", expected words such as t05=robot t01=instrument, with blanks "
      "between them and none beside the '='";
  const auto equals = word.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == word.size())
    return "found " + shown(word) + kExpected;
  const std::string symbol = word.substr(0, equals), part = word.substr(equals + 1);
  if (std::ranges::find(kPartNames, part) == kPartNames.end())
    return "found " + shown(word) + ", expected " + symbol + "=robot, " + symbol +
           "=instrument or " + symbol + "=air" +
           nearest_of(part, {kPartNames.begin(), kPartNames.end()});
  if (data.find(symbol) != nullptr || all_have_parts) return {};
  std::vector<std::string_view> known;
  for (const auto& column : data.columns) known.push_back(column.channel.symbol);
  return "found " + shown(word) + ", but the data have no channel " + shown(symbol) +
         nearest_of(symbol, known);
}

bool every_thermometer_has_a_part(const Dataset& data) {
  const Parts parts = parts_from(data.metadata);
  return std::ranges::all_of(data.columns, [&parts](const DatasetColumn& column) {
    return !is_structure_temperature(column.channel) ||
           std::ranges::find(parts, column.channel.symbol, &Parts::value_type::first) !=
               parts.end();
  });
}

std::string wrong_with(const std::string& key, const std::string& word, const Dataset& data,
                       bool all_have_parts) {
  if (key == kPartsKey) return wrong_with_part(word, data, all_have_parts);
  if (key == kMeasuredByKey && measured_by_from({{key, word}}).empty())
    return "found " + shown(word) +
           ", expected words such as x=laser, ma.rx=level+collimator or x=laser-1*120,laser-2*80, "
           "without blanks inside";
  return {};
}

}  // namespace

std::optional<MetadataSlip> metadata_slip(const Dataset& data) {
  const bool all_have_parts = every_thermometer_has_a_part(data);
  for (std::size_t i = 0; i < data.metadata.size(); ++i) {
    const auto& [key, value] = data.metadata[i];
    if (key == kOverruns && value != "yes" && value != "no")
      return MetadataSlip{i, "found " + shown(value) + ", expected yes or no"};
    std::istringstream words(value);
    for (std::string word; words >> word;)
      if (auto wrong = wrong_with(key, word, data, all_have_parts); !wrong.empty())
        return MetadataSlip{i, std::move(wrong)};
  }
  return std::nullopt;
}

Result<void> check_metadata(std::string_view text, const Dataset& data,
                            const std::string& file_name) {
  const auto slip = metadata_slip(data);
  if (!slip) return {};
  return fail(ErrorCode::invalid_argument, reasons::kBadMetadata,
              at_line(file_name, line_of_entry(text, slip->entry)) + "'# " +
                  data.metadata[slip->entry].first + ":': " + slip->sentence);
}

}  // namespace driftwise::formats
