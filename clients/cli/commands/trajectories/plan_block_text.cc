#include "clients/cli/commands/trajectories/plan_block_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "server/core/try.h"

namespace driftwise::cli {
namespace {

tl::unexpected<Error> bad_block(const std::string& word, const std::string& expected) {
  return fail(ErrorCode::invalid_argument, "BAD_BLOCK",
              "found '" + word + "', expected " + expected);
}

template <class Number>
bool number_into(std::string_view text, Number& value) {
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc{} && end == text.data() + text.size() &&
         std::isfinite(static_cast<double>(value));
}

// "0:2.5:0.5", or "0.1:2.4" where no step is needed.
bool range_from(std::string_view text, GridRange& range) {
  const auto first = text.find(':');
  if (first == std::string_view::npos) return false;
  const auto second = text.find(':', first + 1);
  if (!number_into(text.substr(0, first), range.from_mm)) return false;
  if (second == std::string_view::npos) return number_into(text.substr(first + 1), range.to_mm);
  return number_into(text.substr(first + 1, second - first - 1), range.to_mm) &&
         number_into(text.substr(second + 1), range.step_mm);
}

struct BlockReader {
  const std::vector<Channel>& coordinates;
  PlanBlock block;
  std::vector<bool> given;

  Result<void> take(const std::string& word) {
    const auto equals = word.find('=');
    if (equals == std::string::npos) return take_plain(word);
    const auto name = word.substr(0, equals), value = word.substr(equals + 1);
    double number = 0;
    if (name == "force" || name == "dwell") {
      if (!number_into(value, number)) return bad_block(word, name + "= and a number");
      (name == "force" ? block.force_n : block.dwell_s) = number;
      return {};
    }
    if (name == "scattered")
      return number_into(value, block.scattered) && block.scattered > 0
                 ? Result<void>{}
                 : bad_block(word, "scattered= and a whole number above 0");
    if (name == "seed")
      return number_into(value, block.seed) ? Result<void>{}
                                            : bad_block(word, "seed= and a whole number");
    if (name == "zeros") {
      if (value != "yes" && value != "no") return bad_block(word, "zeros=yes or zeros=no");
      block.zeros = value == "yes";
      return {};
    }
    for (std::size_t i = 0; i < coordinates.size(); ++i)
      if (coordinates[i].symbol == name) return take_range(i, word, value);
    return bad_block(word, "a coordinate, force, dwell, zeros, scattered or seed before the =");
  }

  Result<void> take_plain(const std::string& word) {
    if (word == "calibration" || word == "validation") {
      block.set = word == "validation" ? PointSet::validation : PointSet::calibration;
      return {};
    }
    for (std::size_t i = 0; i < coordinates.size(); ++i)
      if (auto ok = take_range(i, word, word); !ok) return ok;
    return {};
  }

  Result<void> take_range(std::size_t i, const std::string& word, const std::string& range) {
    if (!range_from(range, block.ranges[i]))
      return bad_block(word, "calibration, validation, or a range in mm such as 0:2.5:0.5");
    given[i] = true;
    return {};
  }
};

}  // namespace

Result<PlanBlock> plan_block_from(const std::string& text,
                                  const std::vector<Channel>& coordinates) {
  BlockReader reader{coordinates, {}, std::vector<bool>(coordinates.size(), false)};
  reader.block.ranges.resize(coordinates.size());
  std::istringstream words(text);
  for (std::string word; words >> word;) DRIFTWISE_RETURN_IF_ERROR(reader.take(word));
  const auto missing = std::ranges::find(reader.given, false);
  if (missing != reader.given.end())
    return bad_block(
        text, "a range for " +
                  coordinates[static_cast<std::size_t>(missing - reader.given.begin())].symbol +
                  " such as 0:2.5:0.5");
  return reader.block;
}

Result<std::vector<Channel>> coordinates_from(const std::string& text) {
  std::vector<Channel> out;
  std::istringstream names(text);
  for (std::string name; std::getline(names, name, ',');) {
    DRIFTWISE_TRY(auto channel, parse_robot_channel(name + "_mm"));
    out.push_back(std::move(channel));
  }
  if (out.empty())
    return fail(ErrorCode::invalid_argument, "BAD_CHANNEL",
                "found no coordinates, expected some such as q1,q2,q3");
  return out;
}

}  // namespace driftwise::cli
