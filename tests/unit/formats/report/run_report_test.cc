// The data of a report against what a page would read of them: docs/web-report.md.

#include "server/formats/report/run_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace driftwise::tests {
namespace {

// An oracle of its own: base64 by a table of positions, float32 by memcpy on this little-endian
// machine.
std::vector<float> unpacked_floats(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xff);
  }
  std::vector<float> values(bytes.size() / 4);
  std::memcpy(values.data(), bytes.data(), values.size() * 4);
  return values;
}

TEST(Report, PacksFloatsOfEveryLength) {
  EXPECT_EQ(formats::packed({}), "");
  for (std::size_t size = 1; size < 5; ++size) {
    std::vector<double> values;
    for (std::size_t i = 0; i < size; ++i) values.push_back(1.5 * static_cast<double>(i) - 1);
    const auto back = unpacked_floats(formats::packed(values));
    ASSERT_EQ(back.size(), size);
    for (std::size_t i = 0; i < size; ++i) EXPECT_EQ(back[i], static_cast<float>(values[i]));
  }
  EXPECT_TRUE(std::isnan(unpacked_floats(formats::packed({std::nan("")}))[0]));
}

CellTime after_s(double seconds) { return CellTime{100} + nanoseconds_from_s(seconds); }

formats::RunReport empty_report() {
  formats::RunReport report;
  report.run.started = after_s(0);
  report.utc = [](CellTime at) { return UtcTime{at.utc_ns}; };
  return report;
}

TEST(Report, ResolvesATenthOfANanometreAtTenMillimetres) {
  auto report = empty_report();
  for (int i = 0; i < 2; ++i) {
    auto& point = report.points.emplace_back();
    point.row = i;
    point.measured.utc = after_s(60 + 60 * i);
    point.values = {{"x_mm", 10 + 1.234e-4 * i}};
  }
  const auto data = formats::run_report_json(report);
  const auto& column = data["points"]["columns"][0];
  const auto values = unpacked_floats(column["data"]);
  const double step_nm = (values[1] - values[0]) * column["scale"].get<double>() * 1e6;
  EXPECT_NEAR(step_nm, 123.4, 0.1);
  EXPECT_EQ(unpacked_floats(data["points"]["time_s"])[1], 120);
}

TEST(Report, SaysOfEachPointWhichZeroItCountsFrom) {
  auto report = empty_report();
  for (const std::int64_t datum : {3, 3, 4}) report.points.emplace_back().datum = DatumId{datum};
  const auto data = formats::run_report_json(report);
  EXPECT_THAT(unpacked_floats(data["points"]["datum"]), testing::ElementsAre(3, 3, 4));
}

TEST(Report, TellsHowLongTheRunLastedAlsoWhenTheClockWasSetBackMeanwhile) {
  auto report = empty_report();
  report.utc = [](CellTime at) {
    return UtcTime{at.utc_ns - (at < after_s(20) ? 0 : 3'600'000'000'000)};
  };
  EXPECT_TRUE(formats::run_report_json(report)["run"]["elapsed_s"].is_null()) << "not over";
  report.run.ended = after_s(90.5);
  EXPECT_DOUBLE_EQ(formats::run_report_json(report)["run"]["elapsed_s"].get<double>(), 90.5);
}

TEST(Report, KeepsDataInsideTheirElementWhateverTheyHold) {
  const std::string page =
      "<p>a</p><script type=\"application/json\" id=\"report-data\">null</script><p>b</p>";
  const auto written = *formats::report_page(page, {{"name", "</script><script>alert(1)"}});
  EXPECT_EQ(written.find("</script><script>alert"), std::string::npos);
  const auto from = written.find('{'), to = written.find("</script>");
  EXPECT_EQ(nlohmann::json::parse(written.substr(from, to - from))["name"],
            "</script><script>alert(1)");
}

TEST(Report, RefusesATemplateWithoutOnePlaceForData) {
  const std::string place = "<script type=\"application/json\" id=\"report-data\">null</script>";
  for (const std::string& page : {std::string("<p>hello</p>"), place + place}) {
    const auto refused = formats::report_page(page, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::failed_precondition);
  }
}

TEST(Report, TellsWhoAcknowledgedWhatAndWhatFollowedTheRun) {
  auto report = empty_report();
  QueueEntry entry;
  entry.id = {4};
  entry.name = "night";
  entry.run = RunId{12};
  entry.follow_ups = {"fit:q ~ x"};
  entry.results = {{.position = 0, .good = false, .text = "the fit failed", .at = after_s(9)}};
  report.entries = {entry};
  report.runs.resize(1);
  report.runs[0].state = RunState::done;
  report.runs[0].accepted = 40;
  auto& alarm = report.alarms.emplace_back();
  alarm.kind = "device.lost";
  alarm.subject = "scanner";
  alarm.level = AlarmLevel::warning;
  alarm.since = after_s(1);
  alarm.acknowledged = after_s(2);
  alarm.acknowledged_by = "bob";
  const auto data = formats::run_report_json(report);
  const auto& told = data["alarms"][0];
  EXPECT_EQ(told["acknowledged_by"], "bob");
  EXPECT_EQ(told["priority"], "medium");
  EXPECT_TRUE(told["over"].is_null()) << "it still holds";
  const auto& of_queue = data["queue"]["entries"][0];
  EXPECT_EQ(of_queue["accepted"], 40);
  EXPECT_EQ(of_queue["results"][0]["follow_up"], "fit:q ~ x");
  EXPECT_EQ(of_queue["results"][0]["good"], false);
}

}  // namespace
}  // namespace driftwise::tests
