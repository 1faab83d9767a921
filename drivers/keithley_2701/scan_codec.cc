#include "drivers/keithley_2701/scan_codec.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "server/core/text/trimmed.h"

namespace driftwise::keithley {
namespace {

constexpr double kOverflow = 1e37;
constexpr int kMinChannel = 101,
              kMaxChannel = 599;  // five slots of the 2750; the 2700 and 2701 have two

tl::unexpected<Error> bad_reply(std::string message, Reason reason = reasons::kBadReply) {
  return fail(ErrorCode::data_loss, reason, std::move(message));
}

std::string_view trimmed(std::string_view text) { return driftwise::trimmed(text, " \t\r\n"); }

std::optional<int> read_channel(std::string_view text) {
  text = trimmed(text);
  int value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || value < kMinChannel ||
      value > kMaxChannel)
    return std::nullopt;
  return value;
}

// "+1.0779E+03", "+11.664SECS", "+236RDNG#": the number, if what follows it is a unit.
std::optional<double> read_field(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || !std::isfinite(value)) return std::nullopt;
  for (const char c : text.substr(static_cast<std::size_t>(end - text.data()))) {
    if (!((c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '#')) return std::nullopt;
  }
  return value;
}

bool holds_exactly(std::span<const double> fields, const Layout& layout, std::size_t column,
                   std::span<const int> scanned) {
  std::vector<double> found;
  for (std::size_t i = column; i < fields.size(); i += layout.fields) found.push_back(fields[i]);
  std::vector<double> wanted(scanned.begin(), scanned.end());
  std::sort(found.begin(), found.end());
  std::sort(wanted.begin(), wanted.end());
  return found == wanted;
}

}  // namespace

std::string encode_channel_list(std::span<const int> channels) {
  std::string out = "(@";
  for (std::size_t i = 0; i < channels.size();) {
    std::size_t last = i;
    while (last + 1 < channels.size() && channels[last + 1] == channels[last] + 1) ++last;
    if (i > 0) out += ',';
    out += std::to_string(channels[i]);
    if (last > i) out += (last == i + 1 ? "," : ":") + std::to_string(channels[last]);
    i = last + 1;
  }
  return out + ")";
}

Result<std::vector<int>> parse_channel_list(std::string_view text) {
  text = trimmed(text);
  if (!text.starts_with("(@") || !text.ends_with(')'))
    return bad_reply("expected a channel list such as (@101:110)");
  text = text.substr(2, text.size() - 3);
  std::vector<int> out;
  while (!trimmed(text).empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    const std::string_view item = text.substr(0, comma);
    const std::size_t colon = item.find(':');
    const auto first = read_channel(item.substr(0, colon));
    const auto last =
        colon == std::string_view::npos ? first : read_channel(item.substr(colon + 1));
    if (!first || !last || *last < *first)
      return bad_reply("'" + std::string(item) + "' is no channel or range of channels");
    for (int channel = *first; channel <= *last; ++channel) out.push_back(channel);
    if (out.size() > 1000) return bad_reply("more than 1000 channels");
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return out;
}

Result<DeviceError> parse_device_error(std::string_view reply) {
  reply = trimmed(reply);
  if (reply.starts_with('+')) reply.remove_prefix(1);
  DeviceError out;
  const auto [end, code] = std::from_chars(reply.data(), reply.data() + reply.size(), out.number);
  const std::string_view rest = reply.substr(static_cast<std::size_t>(end - reply.data()));
  if (code != std::errc{} || (!rest.empty() && rest.front() != ','))
    return bad_reply("expected <number>,\"<text>\" of the error queue");
  if (rest.size() > 1) out.text = trimmed(rest.substr(1));
  if (out.text.size() >= 2 && out.text.front() == '"' && out.text.back() == '"')
    out.text = out.text.substr(1, out.text.size() - 2);
  return out;
}

Result<std::vector<double>> parse_fields(std::string_view reply, std::size_t count) {
  reply = trimmed(reply);
  std::vector<double> out;
  std::size_t number = 0;
  while (!reply.empty()) {
    const std::size_t comma = std::min(reply.find(','), reply.size());
    const auto value = read_field(reply.substr(0, comma));
    ++number;
    if (!value) return bad_reply("field " + std::to_string(number) + " is no number");
    out.push_back(*value);
    if (comma + 1 == reply.size()) return bad_reply("the last field is empty");
    reply.remove_prefix(std::min(comma + 1, reply.size()));
    if (out.size() > count) break;
  }
  if (out.size() != count) {
    return bad_reply(
        (out.size() > count ? "more than " + std::to_string(count) : std::to_string(out.size())) +
            " fields, expected " + std::to_string(count),
        reasons::kFieldCount);
  }
  return out;
}

Result<Layout> learn_layout(std::span<const double> fields, std::span<const int> scanned) {
  Layout layout;
  std::vector<std::size_t> candidates;
  for (const std::size_t column : {std::size_t{1}, std::size_t{2}, std::size_t{0}}) {
    if (holds_exactly(fields, layout, column, scanned)) candidates.push_back(column);
  }
  if (candidates.size() != 1) {
    return bad_reply(
        std::string(candidates.empty() ? "no field holds" : "more than one field holds") +
            " the channel numbers " + encode_channel_list(scanned) +
            ": is FORM:ELEM READ,CHAN,TST in effect?",
        reasons::kUnknownLayout);
  }
  layout.channel = candidates.front();
  layout.reading = layout.channel == 0 ? 1 : 0;
  layout.time = layout.channel == 2 ? 1 : 2;
  return layout;
}

Result<std::vector<ChannelReading>> read_scan(std::span<const double> fields, const Layout& layout,
                                              std::span<const int> scanned) {
  if (fields.size() != layout.fields * scanned.size())
    return bad_reply("the scan does not have three fields per channel", reasons::kFieldCount);
  if (!holds_exactly(fields, layout, layout.channel, scanned))
    return bad_reply("the channels of the scan are not " + encode_channel_list(scanned),
                     reasons::kWrongChannel);
  std::vector<ChannelReading> out;
  for (std::size_t at = 0; at < fields.size(); at += layout.fields) {
    const double value = fields[at + layout.reading];
    out.push_back({static_cast<int>(fields[at + layout.channel]),
                   std::abs(value) > kOverflow ? kMissing : value, fields[at + layout.time]});
  }
  return out;
}

}  // namespace driftwise::keithley
