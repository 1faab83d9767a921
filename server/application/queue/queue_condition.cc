#include "server/application/queue/queue_condition.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr double kDay_s = 86'400;
constexpr double kMostSpan_s = 31 * kDay_s;
constexpr double kLeastRecorded = 0.9;  // share of the span of `lowest`

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < text.size();) {
    const auto begin = text.find_first_not_of(" \t", at);
    if (begin == std::string_view::npos) break;
    const auto end = std::min(text.find_first_of(" \t", begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    at = end;
  }
  return words;
}

std::optional<double> finite_number(std::string_view word) {
  double value = 0;
  const auto [end, bad] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (bad != std::errc{} || end != word.data() + word.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::optional<double> span_of(std::string_view count, std::string_view unit) {
  const auto number = finite_number(count);
  const double factor = unit == "s" ? 1 : unit == "min" ? 60 : unit == "h" ? 3600 : 0;
  if (!number || factor == 0 || *number <= 0 || *number * factor > kMostSpan_s) return std::nullopt;
  return *number * factor;
}

tl::unexpected<Error> bad_condition(std::string_view text, const std::string& what) {
  return fail(ErrorCode::invalid_argument, reasons::kBadCondition,
              fmt::format("condition: found {}: {}; expected 'CHANNEL < 20.5 degC for 30 min', "
                          "'CHANNEL > 20.5 degC' or 'CHANNEL coldest within 0.1 degC'",
                          shown(text), what));
}

Result<Channel> channel_of(std::string_view text, std::string_view name,
                           const std::vector<Channel>& channels) {
  const Channel* found = nullptr;
  for (const auto& channel : channels) {
    if (channel.name() != name && channel.symbol != name) continue;
    if (found && channel.name() != name)
      return bad_condition(text,
                           fmt::format("{} may be {} or {}", name, found->name(), channel.name()));
    found = &channel;
  }
  if (found) return *found;
  std::string known;
  for (const auto& channel : channels) {
    if (known.size() > 200) {
      known += " ...";
      break;
    }
    known += (known.empty() ? "" : " ") + channel.name();
  }
  return bad_condition(text, fmt::format("the cell records no {}; it has: {}", shown(name), known));
}

Result<QueueCondition> lowest_from(std::string_view text, QueueCondition condition,
                                   std::vector<std::string_view> words) {
  condition.kind = QueueCondition::Kind::lowest;
  condition.span_s = kDay_s;
  std::size_t at = 2;
  if (words[1] == "lowest") {
    const auto span =
        words.size() >= 5 && words[2] == "of" ? span_of(words[3], words[4]) : std::nullopt;
    if (!span) return bad_condition(text, "how far back is not said ('lowest of 24 h')");
    condition.span_s = *span;
    at = 5;
  }
  const auto tolerance =
      words.size() == at + 3 && words[at] == "within" ? finite_number(words[at + 1]) : std::nullopt;
  if (!tolerance || *tolerance < 0 || words[at + 2] != condition.channel.unit)
    return bad_condition(
        text, fmt::format("how near is not said ('within 0.1 {}')", condition.channel.unit));
  condition.value = *tolerance;
  return condition;
}

bool is_beyond(const QueueCondition& condition, double value) {
  return condition.kind == QueueCondition::Kind::below ? !(value < condition.value)
                                                       : !(value > condition.value);
}

// "t12_degC below 20.5 degC for 30 min".
std::string wish_of(const QueueCondition& condition) {
  const auto name = condition.channel.name();
  const auto size = fmt::format("{} {}", number_text(condition.value), condition.channel.unit);
  if (condition.kind == QueueCondition::Kind::lowest)
    return fmt::format("{} within {} of its lowest of {}", name, size, span_text(condition.span_s));
  auto wish = fmt::format("{} {} {}", name,
                          condition.kind == QueueCondition::Kind::below ? "below" : "above", size);
  if (condition.span_s > 0) wish += " for " + span_text(condition.span_s);
  return wish;
}

ConditionVerdict judge_lowest(const QueueCondition& condition, const ConditionRecord& record,
                              const SeriesColumn& column, const std::string& wish) {
  double lowest = record.newest;
  std::size_t recorded = 0;
  for (std::size_t i = 0; i < column.count.size(); ++i) {
    if (column.count[i] == 0 || is_missing(column.min[i])) continue;
    ++recorded;
    lowest = std::min(lowest, column.min[i]);
  }
  const double share =
      static_cast<double>(recorded) / std::max<double>(1, static_cast<double>(column.count.size()));
  if (share < kLeastRecorded)
    return {false, fmt::format("{}: {:.0f} % of that time is recorded", wish, 100 * share)};
  const bool met = record.newest - lowest <= condition.value;
  return {met, fmt::format("{}: {} now, lowest {}", wish, digits_text(record.newest, 5),
                           digits_text(lowest, 5))};
}

}  // namespace

std::vector<Channel> channels_for_conditions(const CellDescription& description) {
  std::vector<Channel> channels;
  const auto add = [&](const std::vector<Channel>& further) {
    for (const auto& channel : further)
      if (std::ranges::find(channels, channel) == channels.end()) channels.push_back(channel);
  };
  add(description.temperature_channels());
  add(description.motor_channels());
  add(description.length_channels());
  add(description.angle_channels());
  for (const auto& device : description.devices) add(device.channels);
  return channels;
}

std::string span_text(double seconds) {
  if (seconds >= 3600) return digits_text(seconds / 3600, 4) + " h";
  if (seconds >= 60) return digits_text(seconds / 60, 4) + " min";
  return digits_text(seconds, 4) + " s";
}

Result<QueueCondition> parse_condition(std::string_view text,
                                       const std::vector<Channel>& channels) {
  auto words = words_of(text);
  if (words.size() < 3) return bad_condition(text, "it is too short");
  QueueCondition condition;
  DRIFTWISE_TRY(condition.channel, channel_of(text, words[0], channels));
  if (words[1] == "coldest" || words[1] == "lowest")
    return lowest_from(text, std::move(condition), std::move(words));
  if (words[1] != "<" && words[1] != ">")
    return bad_condition(text, fmt::format("{} is no comparison", shown(words[1])));
  condition.kind = words[1] == "<" ? QueueCondition::Kind::below : QueueCondition::Kind::above;
  const auto value = finite_number(words[2]);
  if (!value) return bad_condition(text, fmt::format("{} is no number", shown(words[2])));
  condition.value = *value;
  if (words.size() < 4 || words[3] != condition.channel.unit)
    return bad_condition(
        text, fmt::format("{} is in {}", condition.channel.name(), condition.channel.unit));
  if (words.size() == 4) return condition;
  const auto span =
      words.size() == 7 && words[4] == "for" ? span_of(words[5], words[6]) : std::nullopt;
  if (!span) return bad_condition(text, "how long is not said ('for 30 min', at most 31 days)");
  condition.span_s = *span;
  return condition;
}

std::string to_string(const QueueCondition& condition) {
  const auto size = fmt::format("{} {}", number_text(condition.value), condition.channel.unit);
  const auto name = condition.channel.name();
  // As written: whole seconds where the larger units are no round number.
  const auto span = [](double s) {
    if (std::fmod(s, 3600) == 0) return fmt::format("{:.0f} h", s / 3600);
    if (std::fmod(s, 60) == 0) return fmt::format("{:.0f} min", s / 60);
    return number_text(s) + " s";
  };
  if (condition.kind == QueueCondition::Kind::lowest)
    return fmt::format("{} lowest of {} within {}", name, span(condition.span_s), size);
  const char sign = condition.kind == QueueCondition::Kind::below ? '<' : '>';
  auto text = fmt::format("{} {} {}", name, sign, size);
  if (condition.span_s > 0) text += " for " + span(condition.span_s);
  return text;
}

int buckets_for(const QueueCondition& condition) {
  constexpr int kMost = 96;
  const double least_s = condition.kind == QueueCondition::Kind::lowest ? 900 : 60;
  return std::clamp(static_cast<int>(condition.span_s / least_s), 1, kMost);
}

ConditionVerdict judge(const QueueCondition& condition, const ConditionRecord& record,
                       CellTime now) {
  const auto wish = wish_of(condition);
  if (is_missing(record.newest)) return {false, wish + ": it was never read"};
  if (record.age_s > record.most_age_s)
    return {false, fmt::format("{}: no value for {}", wish, span_text(record.age_s))};
  const auto newest = digits_text(record.newest, 5);
  const bool is_lowest = condition.kind == QueueCondition::Kind::lowest;
  if (!is_lowest && is_beyond(condition, record.newest))
    return {false, fmt::format("{}: {} now", wish, newest)};
  if (condition.span_s == 0) return {true, fmt::format("{}: {} now", wish, newest)};
  if (record.series.columns.empty() || !record.series.columns.front().recorded)
    return {false, wish + ": nothing is recorded"};
  const auto& column = record.series.columns.front();
  if (is_lowest) return judge_lowest(condition, record, column, wish);
  // A channel that is read more seldom than a bucket is long leaves some empty: a gap is longer
  // than its readings may be apart. The newest bucket may still be on its way to the record: the
  // newest value stands for it.
  std::optional<std::size_t> beyond, gap;
  const double bucket_s = seconds_from(record.series.bucket);
  double empty_s = 0;
  for (std::size_t i = 0; i < column.count.size(); ++i) {
    const bool is_last = i + 1 == column.count.size() && i > 0;
    const bool is_empty = column.count[i] == 0 || is_missing(column.min[i]);
    empty_s = is_empty ? empty_s + bucket_s : 0;
    if (is_empty) {
      if (!is_last && empty_s > record.most_age_s) gap = i;
    } else if (is_beyond(condition, column.min[i]) || is_beyond(condition, column.max[i])) {
      beyond = i;
    }
  }
  if (gap && (!beyond || *gap > *beyond))
    return {false, fmt::format("{}: {} now, the record of that time has a gap", wish, newest)};
  if (!beyond) return {true, fmt::format("{}: {} now", wish, newest)};
  const auto since =
      record.series.from + record.series.bucket * static_cast<std::int64_t>(*beyond + 1);
  const double held_s = std::max(0.0, seconds_from(now - since));
  return {false, fmt::format("{}: {} now, for {}", wish, newest, span_text(std::round(held_s)))};
}

}  // namespace driftwise::application
