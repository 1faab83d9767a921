// Messages: the webhook's fields as Alertmanager documents them, and words for people.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "server/notify/mail_text.h"
#include "server/notify/notice_json.h"
#include "server/notify/notice_text.h"

namespace driftwise::notify {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;
constexpr std::int64_t kSecond = 1'000'000'000;

AlarmNews news_of(std::int64_t id, const std::string& kind, const std::string& subject,
                  NewsKind what = NewsKind::firing, AlarmLevel level = AlarmLevel::failed) {
  AlarmNews news;
  news.kind = what;
  news.alarm.id = {id};
  news.alarm.level = level;
  news.alarm.kind = kind;
  news.alarm.subject = subject;
  news.alarm.message = subject + " does not answer";
  news.alarm.consequences = {"run 3 waits", "x_mm is old"};
  news.since = {1'795'248'000 * kSecond};
  if (what == NewsKind::resolved) news.cleared = {1'795'248'060 * kSecond};
  return news;
}

Notice notice_of(std::vector<AlarmNews> news) {
  return {"cell-a", "http://127.0.0.1:8080/", {1'795'248'090 * kSecond}, std::move(news), false};
}

// prometheus.io/docs/alerting/latest/configuration, webhook_config.
TEST(WebhookJson, HasTheFieldsOfAlertmanager) {
  const auto body = json::parse(webhook_json(
      "duty", notice_of({news_of(7, "device.lost", "laser"), news_of(8, "device.lost", "axis")})));
  EXPECT_EQ(body.at("version"), "4");
  EXPECT_EQ(body.at("status"), "firing");
  EXPECT_EQ(body.at("receiver"), "duty");
  EXPECT_EQ(body.at("truncatedAlerts"), 0);
  EXPECT_TRUE(body.at("groupKey").is_string());
  EXPECT_EQ(body.at("groupLabels"), (json{{"cell", "cell-a"}}));
  EXPECT_EQ(body.at("commonLabels"), (json{{"alertname", "device.lost"},
                                           {"cell", "cell-a"},
                                           {"priority", "high"},
                                           {"severity", "critical"}}));
  EXPECT_EQ(body.at("externalURL"), "http://127.0.0.1:8080/");
  ASSERT_EQ(body.at("alerts").size(), 2U);
  const auto& alert = body.at("alerts")[0];
  EXPECT_EQ(alert.at("status"), "firing");
  EXPECT_EQ(alert.at("labels").at("subject"), "laser");
  EXPECT_EQ(alert.at("annotations").at("summary"), "laser does not answer");
  EXPECT_EQ(alert.at("annotations").at("description"), "run 3 waits\nx_mm is old");
  EXPECT_EQ(alert.at("startsAt"), "2026-11-21T08:00:00Z");
  EXPECT_EQ(alert.at("endsAt"), "0001-01-01T00:00:00Z");
  EXPECT_EQ(alert.at("fingerprint").get<std::string>().size(), 16U);
  EXPECT_NE(alert.at("fingerprint"), body.at("alerts")[1].at("fingerprint"));
}

// A full disk: it is told from memory.
TEST(Notice, OfAnAlarmThatIsNotOnRecordYetNamesNoNumber) {
  const auto notice = notice_of({news_of(-2, "record.unwritten", "database")});
  EXPECT_THAT(text_of(notice), HasSubstr("not on record yet, record.unwritten, since"));
  EXPECT_THAT(text_of(notice), Not(HasSubstr("acknowledge")));
  const auto body = json::parse(webhook_json("duty", notice));
  EXPECT_FALSE(body.at("alerts")[0].at("annotations").contains("alarm"));
}

// What Alertmanager 0.25.0 (Debian 12) itself posted to a webhook for one alert.
constexpr const char* kOfAlertmanager = R"json({"receiver":"duty","status":"firing","alerts":[
{"status":"firing","labels":{"alertname":"device.lost","cell":"a","severity":"critical"},
"annotations":{"summary":"x"},"startsAt":"2026-11-22T23:41:22.096195283Z",
"endsAt":"0001-01-01T00:00:00Z","generatorURL":"","fingerprint":"4a1e46ca8ca486b3"}],
"groupLabels":{"cell":"a"},"commonLabels":{"alertname":"device.lost","cell":"a",
"severity":"critical"},"commonAnnotations":{"summary":"x"},"externalURL":"http://vm:0",
"version":"4","groupKey":"{}:{cell=\"a\"}","truncatedAlerts":0})json";

// Keys with the types of their values; of labels and annotations the type only.
json shape_of(const json& body) {
  json shape;
  for (const auto& [key, value] : body.items())
    shape[key] = key == "alerts" ? shape_of(value.at(0)) : json(value.type_name());
  return shape;
}

TEST(WebhookJson, HasTheShapeOfWhatAlertmanagerPosts) {
  const auto ours =
      json::parse(webhook_json("duty", notice_of({news_of(7, "device.lost", "laser")})));
  const auto theirs = json::parse(kOfAlertmanager);
  EXPECT_EQ(shape_of(ours), shape_of(theirs));
  EXPECT_EQ(ours.at("alerts")[0].at("endsAt"), theirs.at("alerts")[0].at("endsAt"));
}

TEST(WebhookJson, IsResolvedWhenAllOfItIs) {
  const auto over = news_of(7, "device.lost", "laser", NewsKind::resolved);
  const auto all = json::parse(webhook_json("duty", notice_of({over})));
  EXPECT_EQ(all.at("status"), "resolved");
  EXPECT_EQ(all.at("alerts")[0].at("endsAt"), "2026-11-21T08:01:00Z");
  const auto one =
      json::parse(webhook_json("duty", notice_of({over, news_of(8, "device.lost", "axis")})));
  EXPECT_EQ(one.at("status"), "firing");
  EXPECT_EQ(one.at("alerts")[0].at("status"), "resolved");
  // The same condition has the same fingerprint, so that a receiver knows which one is over.
  const auto firing =
      json::parse(webhook_json("duty", notice_of({news_of(7, "device.lost", "laser")})));
  EXPECT_EQ(firing.at("alerts")[0].at("fingerprint"), all.at("alerts")[0].at("fingerprint"));
}

TEST(WebhookJson, HostileTextStaysText) {
  auto news = news_of(7, "device.lost", "laser");
  news.alarm.message = "a\"b\\c\n\xff\x1b[31m";
  const auto body = json::parse(webhook_json("duty", notice_of({news})));
  EXPECT_EQ(body.at("alerts")[0].at("annotations").at("summary"), "a\"b\\c ??[31m");
}

TEST(NoticeText, NamesTheGravestFirst) {
  const auto notice =
      notice_of({news_of(7, "gate.spread", "run 3", NewsKind::firing, AlarmLevel::warning),
                 news_of(8, "motion.uncommanded", "axes"),
                 news_of(9, "device.lost", "laser", NewsKind::resolved)});
  EXPECT_EQ(title_of(notice), "[cell-a] critical: axes does not answer (and 2 more)");
  EXPECT_THAT(text_of(notice), HasSubstr("over: laser does not answer\n  hence: run 3 waits"));
  EXPECT_EQ(title_of(notice_of({})), "[cell-a] a test: nothing is wrong");
}

// Somebody at home reads it: "a wrong token" says nothing without where it came from.
TEST(NoticeText, HasTheSubjectWhereTheSentenceHasItNot) {
  auto news = news_of(7, "record.unwritten", "database");
  news.alarm.message = "the record takes nothing";
  EXPECT_EQ(title_of(notice_of({news})), "[cell-a] high: database: the record takes nothing");
  EXPECT_THAT(text_of(notice_of({news})), HasSubstr("high: database: the record takes nothing\n"));
  news.alarm.subject = "t07_degC above 21";
  news.alarm.message = "t07_degC is 21.5: a limit of this cell file is above 21";
  EXPECT_EQ(title_of(notice_of({news})), "[cell-a] high: " + news.alarm.message);
  news.alarm.subject = "laser-x";
  news.alarm.message = "laser-xy does not answer";
  EXPECT_EQ(title_of(notice_of({news})), "[cell-a] high: laser-x: laser-xy does not answer");
}

TEST(NoticeText, HasTheRemedyThatItCarriesAndNoOther) {
  auto notice = notice_of({news_of(1, "cell.silent", "cell-a")});
  notice.remedy = "go and look";
  EXPECT_THAT(text_of(notice), HasSubstr("\ngo and look\n"));
  EXPECT_THAT(text_of(notice), HasSubstr("  alarm 1, cell.silent, since"));
  notice.is_of_record = false;  // a watchdog's: its 1 is another alarm's number in the cell
  EXPECT_THAT(text_of(notice), HasSubstr("  cell.silent, since"));
  EXPECT_THAT(text_of(notice), Not(HasSubstr("alarm 1")));
  EXPECT_THAT(text_of(notice), Not(HasSubstr("driftwise alarms acknowledge")));
  EXPECT_FALSE(json::parse(webhook_json("duty", notice))
                   .at("alerts")[0]
                   .at("annotations")
                   .contains("alarm"));
}

TEST(MailText, WrapsLongSubjectsOfAnyLanguage) {
  std::string subject;
  for (int i = 0; i < 40; ++i) subject += "größer ";
  const auto mail = rfc5322({"a@x", {"b@x", "c@x"}, subject, "line\n", "1@x", 1'795'248'000});
  EXPECT_THAT(mail, HasSubstr("Date: Sat, 21 Nov 2026 08:00:00 +0000\r\n"));
  std::size_t begin = 0;
  for (auto end = mail.find("\r\n"); end != std::string::npos; end = mail.find("\r\n", begin)) {
    EXPECT_LE(end - begin, 78U) << mail.substr(begin, end - begin);
    begin = end + 2;
  }
  EXPECT_EQ(mail.find("\r\n\r\n\r\n"), std::string::npos);
}

TEST(LifeSignJson, IsReadAsItWasWritten) {
  LifeSign sign{"cell-a", "0.1", {1'795'248'000 * kSecond},  "running",
                4,        2,     {17, std::string(64, 'a')}, 30};
  const auto read = life_sign_from(life_sign_json(sign));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->cell, "cell-a");
  EXPECT_EQ(read->at, sign.at);
  EXPECT_EQ(read->head, sign.head);
  EXPECT_EQ(read->run_state, "running");
  EXPECT_EQ(read->every_s, 30);
  for (const char* bad : {"", "[]", "{}", R"({"cell": 3, "at": "2026-11-21T08:00:00Z"})",
                          R"({"cell": "a", "at": "yesterday"})",
                          R"({"cell": "a", "at": "2026-11-21T08:00:00Z", "chain": "x"})"})
    EXPECT_EQ(life_sign_from(bad).error().reason, "BAD_LIFE_SIGN") << bad;
}

}  // namespace
}  // namespace driftwise::notify
