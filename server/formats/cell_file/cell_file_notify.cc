#include "server/formats/cell_file/cell_file_notify.h"

#include <algorithm>
#include <array>
#include <set>

#include "server/core/records/alarm_kinds.h"
#include "server/formats/cell_file/cell_file_address.h"
#include "server/formats/cell_file/cell_file_holds.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

constexpr std::array<std::string_view, 7> kDays = {"mon", "tue", "wed", "thu", "fri", "sat", "sun"};

std::string_view host_of_url(std::string_view url) {
  const auto begin = url.find("://");
  std::string_view rest = begin == std::string_view::npos ? url : url.substr(begin + 3);
  rest = rest.substr(0, rest.find('/'));
  if (rest.starts_with('[')) return rest.substr(0, rest.find(']') + 1);
  return rest.substr(0, rest.find(':'));
}

bool is_loopback(std::string_view url) {
  const auto host = host_of_url(url);
  return host == "localhost" || host == "[::1]" || host.starts_with("127.");
}

bool has_user(std::string_view url) {
  const auto begin = url.find("://");
  return begin != std::string_view::npos &&
         url.substr(begin + 3, url.find('/', begin + 3) - begin - 3).find('@') !=
             std::string_view::npos;
}

void check_url(TomlReader& reader, const char* key, const std::string& url, std::string_view plain,
               std::string_view secure, const char* example) {
  const bool known = url.starts_with(plain) || url.starts_with(secure);
  const bool odd = std::ranges::any_of(
      url, [](char c) { return static_cast<unsigned char>(c) <= ' ' || c == '\x7f'; });
  if (!known || odd || host_of_url(url).empty() || has_user(url))
    reader.refuse(key, reasons::kBadReceiver,
                  "found " + shown(url) + ", expected an address such as " + example +
                      ", without blanks and without a user before the host");
}

// "18:00-07:00"
bool read_minute(std::string_view text, int& minute) {
  if (text.size() != 5 || text[2] != ':') return false;
  for (const std::size_t i : {0U, 1U, 3U, 4U})
    if (text[i] < '0' || text[i] > '9') return false;
  const int hour = (text[0] - '0') * 10 + text[1] - '0';
  const int rest = (text[3] - '0') * 10 + text[4] - '0';
  minute = hour * 60 + rest;
  return hour <= 24 && rest < 60 && minute <= 24 * 60;
}

void read_hours(TomlReader& reader, ReceiverDescription& out) {
  std::string hours;
  reader.text("hours", hours);
  if (!hours.empty() &&
      (hours.size() != 11 || hours[5] != '-' || !read_minute(hours.substr(0, 5), out.from_minute) ||
       !read_minute(hours.substr(6), out.to_minute)))
    reader.refuse("hours", reasons::kBadTime,
                  "found " + shown(hours) +
                      ", expected a span of local time such as \"18:00-07:00\", which may cross "
                      "midnight");
  std::vector<std::string> days;
  reader.texts("days", days);
  if (days.empty()) return;
  out.days = 0;
  for (const auto& day : days) {
    const auto found = std::ranges::find(kDays, day);
    if (found == kDays.end())
      return reader.refuse("days", reasons::kBadTime,
                           "found " + shown(day) +
                               ", expected some of mon, tue, wed, thu, fri, "
                               "sat, sun");
    out.days |= 1U << static_cast<unsigned>(found - kDays.begin());
  }
}

void check_means(TomlReader& reader, const ReceiverDescription& one) {
  const int ways = int{!one.webhook.empty()} + int{!one.smtp.empty()} + int{!one.command.empty()};
  if (ways != 1)
    return reader.refuse("name", reasons::kBadReceiver,
                         "found " + std::to_string(ways) +
                             " of webhook, smtp and command, expected exactly one of them");
  if (!one.webhook.empty())
    check_url(reader, "webhook", one.webhook, "http://", "https://",
              "\"https://alerts.example.org/hook\"");
  if (!one.smtp.empty())
    check_url(reader, "smtp", one.smtp, "smtp://", "smtps://", "\"smtps://mail.example.org:465\"");
  if (!one.smtp.empty() && (one.from.empty() || one.to.empty()))
    reader.refuse(one.from.empty() ? "from" : "to", reasons::kMissingKey,
                  "found smtp without from or to, expected both: who sends the mail, and a list of "
                  "addresses that get it");
  if (one.smtp.empty() &&
      (!one.from.empty() || !one.to.empty() || !one.user.empty() || !one.password_file.empty()))
    reader.refuse("name", reasons::kBadReceiver,
                  "found from, to, user or password_file without smtp: they belong to a mail");
  // No shell divides it into words.
  if (!one.command.empty())
    if (const auto& program = one.command.front();
        program.find('{') != std::string::npos ||
        (program.find(' ') != std::string::npos && program.find('/') == std::string::npos))
      reader.refuse("command", reasons::kBadReceiver,
                    "found the program " + shown(program) +
                        ", expected a list of program and arguments such as [\"apprise\", \"-b\", "
                        "\"{text}\"]");
  if (one.user.empty() != one.password_file.empty())
    reader.refuse("user", reasons::kMissingKey,
                  "found one of user and password_file, expected both: they belong together");
  if (one.webhook.empty() && !one.token_file.empty())
    reader.refuse("token_file", reasons::kBadReceiver,
                  "found token_file without webhook: it belongs to one");
  if (!one.token_file.empty() && one.webhook.starts_with("http://") && !is_loopback(one.webhook))
    reader.refuse("webhook", reasons::kNeedsTls,
                  "found a token for " + shown(one.webhook) +
                      ": it would cross the network readable by everybody; expected https://");
  for (const auto* address : {&one.from, &one.user})
    if (address->find_first_of("\r\n<>") != std::string::npos)
      reader.refuse("from", reasons::kBadReceiver, "found " + shown(*address));
  for (const auto& address : one.to)
    if (address.find('@') == std::string::npos ||
        address.find_first_of("\r\n<> ") != std::string::npos)
      reader.refuse("to", reasons::kBadReceiver,
                    "found " + shown(address) + ", expected an address such as ada@example.org");
}

// "device.lost", or "run.*" for all that begin with it.
void check_kind(TomlReader& reader, const std::string& pattern) {
  const bool is_start = pattern.ends_with('*');
  const std::string_view wanted = std::string_view(pattern).substr(0, pattern.size() - is_start);
  std::vector<std::string_view> known(kAlarmKinds.begin(), kAlarmKinds.end());
  std::set<std::string> groups;  // "run.*"
  for (const auto kind : known) {
    if (is_start ? kind.starts_with(wanted) : kind == wanted) return;
    groups.insert(std::string(kind.substr(0, kind.find('.') + 1)) + "*");
  }
  known.insert(known.end(), groups.begin(), groups.end());
  const std::string nearest = nearest_word(pattern, known);
  reader.refuse("kinds", reasons::kBadReceiver,
                "found " + shown(pattern) + ", which no alarm has as its kind" +
                    (nearest.empty() ? ", expected kinds such as \"device.lost\" or \"run.*\" "
                                       "(docs/alarms.md lists them)"
                                     : "; did you mean " + shown(nearest) + "?"));
}

void read_receiver(TomlReader&& reader, CellDescription& cell) {
  ReceiverDescription one;
  reader.text("name", one.name, Need::required);
  reader.text("webhook", one.webhook);
  reader.text("smtp", one.smtp);
  reader.texts("command", one.command);
  reader.text("token_file", one.token_file);
  reader.text("from", one.from);
  reader.texts("to", one.to);
  reader.text("user", one.user);
  reader.text("password_file", one.password_file);
  reader.text("ca_file", one.ca_file);
  reader.texts("levels", one.levels);
  for (const auto& level : one.levels)
    if (level != "notice" && level != "warning" && level != "failed")
      reader.refuse("levels", reasons::kBadReceiver,
                    "found " + shown(level) + ", expected some of notice, warning, failed");
  reader.texts("kinds", one.kinds);
  for (const auto& kind : one.kinds) check_kind(reader, kind);
  read_hours(reader, one);
  reader.number("repeat_h", one.repeat_h, {.min = 0, .max = 8784});
  reader.number("group_s", one.group_s, {.min = 0, .max = 3600});
  reader.truth("resolved", one.resolved);
  check_means(reader, one);
  if (std::ranges::find(cell.receivers, one.name, &ReceiverDescription::name) !=
      cell.receivers.end())
    reader.refuse("name", reasons::kDuplicateId,
                  "found " + shown(one.name) + ", which another [[notify]] has already");
  reader.finish();
  cell.receivers.push_back(std::move(one));
}

void read_watchdog(TomlReader&& reader, WatchdogRules& out) {
  reader.text("url", out.url, Need::required);
  reader.number("every_s", out.every_s, {.min = 1, .max = 3600});
  reader.text("token_file", out.token_file);
  reader.text("ca_file", out.ca_file);
  check_url(reader, "url", out.url, "http://", "https://", "\"https://watch.example.org:9470/\"");
  if (!out.token_file.empty() && out.url.starts_with("http://") && !is_loopback(out.url))
    reader.refuse("url", reasons::kNeedsTls,
                  "found a token for " + shown(out.url) +
                      ": it would cross the network readable by everybody; expected https://");
  reader.finish();
}

void read_channel_alarm(TomlReader&& reader, CellDescription& cell) {
  ChannelAlarmDescription one;
  Channel channel;
  reader.robot_channel("channel", channel, Need::required);
  one.channel = channel.name();
  check_is_read(reader, "channel", one.channel, channels_read(cell));
  double limit = 0;
  reader.number("above", limit);
  if (reader.has("above")) one.above = limit;
  reader.number("below", limit);
  if (reader.has("below")) one.below = limit;
  if (one.above.has_value() == one.below.has_value())
    reader.refuse("channel", reasons::kBadLimits,
                  "found " + std::string(one.above ? "both" : "none") +
                      " of above and below, expected exactly one of them");
  reader.number("hysteresis", one.hysteresis, {.min = 0});
  reader.number("for_s", one.for_s, {.min = 0, .max = 86'400});
  reader.choice("priority", one.priority, {"low", "medium", "high", "critical"}, Need::optional);
  reader.text("sentence", one.sentence);
  for (const auto& other : cell.channel_alarms)
    if (other.channel == one.channel && other.above == one.above && other.below == one.below)
      reader.refuse("channel", reasons::kDuplicateId,
                    "found the limit of another [[channel_alarm]] of " + shown(one.channel));
  reader.finish();
  cell.channel_alarms.push_back(std::move(one));
}

}  // namespace

void read_notify(TomlReader& top, CellDescription& out, TomlProblem& problem) {
  constexpr std::size_t kMostReceivers = 16;
  for (const auto* table : top.tables("notify")) {
    const std::string place = "notify " + std::to_string(out.receivers.size() + 1);
    read_receiver(TomlReader(*table, place, problem), out);
  }
  if (out.receivers.size() > kMostReceivers)
    top.refuse("notify", reasons::kOutOfRange,
               "found " + std::to_string(out.receivers.size()) + " receivers, expected at most 16");
  if (const auto* watchdog = top.table("watchdog"))
    read_watchdog(TomlReader(*watchdog, "watchdog", problem), out.watchdog);
  for (const auto* table : top.tables("channel_alarm")) {
    const std::string place = "channel_alarm " + std::to_string(out.channel_alarms.size() + 1);
    read_channel_alarm(TomlReader(*table, place, problem), out);
  }
}

}  // namespace driftwise::formats
