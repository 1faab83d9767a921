#include "server/notify/notice_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/notify/notice_text.h"

namespace driftwise::notify {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kNever = "0001-01-01T00:00:00Z";  // as Alertmanager writes it

std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json labels_of(const std::string& cell, const AlarmRecord& alarm) {
  return {{"alertname", alarm.kind},
          {"cell", cell},
          {"priority", to_string(alarm.priority())},
          {"severity", severity_of(alarm)},
          {"subject", clean_line(alarm.subject)}};
}

Json alert_of(const Notice& notice, const AlarmNews& news) {
  const AlarmRecord& alarm = news.alarm;
  std::string hence;
  for (const auto& one : alarm.consequences) hence += (hence.empty() ? "" : "\n") + clean_line(one);
  Json annotations = {{"summary", clean_line(alarm.message)}};
  if (is_on_record(notice, alarm)) annotations["alarm"] = std::to_string(alarm.id.value);
  if (!hence.empty()) annotations["description"] = hence;
  if (alarm.acknowledged.utc_ns != 0)
    annotations["acknowledged_by"] = clean_line(alarm.acknowledged_by);
  const bool over = news.kind == NewsKind::resolved;
  const UtcTime end = news.cleared.ns != 0 ? news.cleared : notice.at;
  return {{"status", over ? "resolved" : "firing"},
          {"labels", labels_of(notice.cell, alarm)},
          {"annotations", annotations},
          {"startsAt", to_iso8601(news.since)},
          {"endsAt", over ? to_iso8601(end) : kNever},
          {"generatorURL", notice.web_address},
          {"fingerprint", fingerprint_of(notice.cell, alarm)}};
}

// Those that all alerts have with the same value.
Json common(const Json& alerts, const char* what) {
  Json same = alerts.front().at(what);
  for (const auto& alert : alerts)
    for (auto it = same.begin(); it != same.end();)
      it = alert.at(what).value(it.key(), Json()) == it.value() ? std::next(it) : same.erase(it);
  return same;
}

}  // namespace

std::string webhook_json(const std::string& receiver, const Notice& notice) {
  Notice told = notice;
  if (told.news.empty()) {
    AlarmNews news;
    news.alarm.kind = "notify.test";
    news.alarm.subject = receiver;
    news.alarm.message = "a test: nothing is wrong";
    news.since = notice.at;
    told.news.push_back(std::move(news));
  }
  Json alerts = Json::array();
  for (const auto& news : told.news) alerts.push_back(alert_of(told, news));
  return dumped({{"version", "4"},
                 {"groupKey", "{}:{cell=\"" + clean_line(notice.cell) + "\"}"},
                 {"truncatedAlerts", 0},
                 {"status", is_resolved(told) ? "resolved" : "firing"},
                 {"receiver", receiver},
                 {"groupLabels", {{"cell", notice.cell}}},
                 {"commonLabels", common(alerts, "labels")},
                 {"commonAnnotations", common(alerts, "annotations")},
                 {"externalURL", notice.web_address},
                 {"alerts", alerts}});
}

std::string life_sign_json(const LifeSign& sign) {
  return dumped({{"cell", sign.cell},
                 {"version", sign.version},
                 {"at", to_iso8601(sign.at)},
                 {"run", sign.run},
                 {"run_state", sign.run_state},
                 {"alarms", sign.alarms},
                 {"chain", sign.head.entry == 0 ? "" : to_string(sign.head)},
                 {"every_s", sign.every_s}});
}

Result<LifeSign> life_sign_from(const std::string& text) {
  const auto bad = [](const std::string& found) {
    return fail(ErrorCode::invalid_argument, reasons::kBadLifeSign,
                "a sign of life " + found +
                    ", expected {\"cell\", \"at\", \"chain\", ...} as "
                    "driftwised sends it");
  };
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return bad("is no JSON object");
  LifeSign sign;
  const auto text_of_key = [&json](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_string() ? clean_line(found->get<std::string>())
                                                     : std::string();
  };
  const auto whole = [&json](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
  };
  sign.cell = text_of_key("cell");
  if (sign.cell.empty() || sign.cell.size() > 200) return bad("has no name of a cell");
  const auto at = parse_iso8601(text_of_key("at"));
  if (!at) return bad("of " + sign.cell + " has no instant");
  sign.at = {at->utc_ns};
  sign.version = text_of_key("version");
  sign.run_state = text_of_key("run_state");
  sign.run = whole("run");
  sign.alarms = whole("alarms");
  if (const auto chain = text_of_key("chain"); !chain.empty()) {
    const auto head = chain_head_from(chain);
    if (!head) return bad("of " + sign.cell + " has a chain that is no HASH@N");
    sign.head = *head;
  }
  const auto every = json.find("every_s");
  if (every != json.end() && every->is_number()) sign.every_s = every->get<double>();
  if (!std::isfinite(sign.every_s) || sign.every_s < 0 || sign.every_s > 86'400) sign.every_s = 0;
  return sign;
}

}  // namespace driftwise::notify
