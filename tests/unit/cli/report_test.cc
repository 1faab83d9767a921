// The data of a report against what a page would read of them: docs/web-report.md.

#include <cmath>
#include <cstring>

#include "clients/cli/commands/runs/report_data.h"
#include "tests/unit/cli/cli_fixture.h"

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
  EXPECT_EQ(cli::packed({}), "");
  for (std::size_t size = 1; size < 5; ++size) {
    std::vector<double> values;
    for (std::size_t i = 0; i < size; ++i) values.push_back(1.5 * static_cast<double>(i) - 1);
    const auto back = unpacked_floats(cli::packed(values));
    ASSERT_EQ(back.size(), size);
    for (std::size_t i = 0; i < size; ++i) EXPECT_EQ(back[i], static_cast<float>(values[i]));
  }
  EXPECT_TRUE(std::isnan(unpacked_floats(cli::packed({std::nan("")}))[0]));
}

TEST(Report, ResolvesATenthOfANanometreAtTenMillimetres) {
  cli::ReportSource source;
  source.run.mutable_run()->mutable_start_time()->set_seconds(100);
  for (int i = 0; i < 2; ++i) {
    auto& point = source.points.emplace_back();
    point.set_row(i);
    point.mutable_measure_time()->set_seconds(160 + 60 * i);
    auto& x = *point.add_values();
    x.set_channel("x_mm");
    x.set_value(10 + 1.234e-4 * i);
  }
  const auto data = cli::report_json(source);
  const auto& column = data["points"]["columns"][0];
  const auto values = unpacked_floats(column["data"]);
  const double step_nm = (values[1] - values[0]) * column["scale"].get<double>() * 1e6;
  EXPECT_NEAR(step_nm, 123.4, 0.1);
  EXPECT_EQ(unpacked_floats(data["points"]["time_s"])[1], 120);
}

TEST(Report, KeepsDataInsideTheirElementWhateverTheyHold) {
  const std::string page =
      "<p>a</p><script type=\"application/json\" id=\"report-data\">null</script><p>b</p>";
  const auto written = cli::report_page(page, {{"name", "</script><script>alert(1)"}});
  EXPECT_EQ(written.find("</script><script>alert"), std::string::npos);
  const auto from = written.find('{'), to = written.find("</script>");
  EXPECT_EQ(nlohmann::json::parse(written.substr(from, to - from))["name"],
            "</script><script>alert(1)");
}

class ReportCommandTest : public CliTest {};

TEST_F(ReportCommandTest, WritesOnePageAndRefusesWhatIsNoTemplate) {
  json({"run", "start", file("plan.csv", "x_mm\n0\n1\n0\n")});
  const auto page =
      file("report.html", "<script type=\"application/json\" id=\"report-data\">null</script>");
  const auto out = file("run.html", "");
  const auto said = json({"report", "run", "1", "-o", out, "--template", page});
  EXPECT_EQ(said["run_id"], 1);
  EXPECT_GT(said["bytes"], 200);
  const auto bad = file("other.html", "<p>hello</p>");
  EXPECT_EQ(run({"report", "run", "1", "-o", out, "--template", bad}).exit, 3);
  EXPECT_EQ(run({"report", "run", "1", "-o", out, "--template", "/nowhere.html"}).exit, 3);
  EXPECT_NE(run({"report", "run", "99", "-o", out, "--template", page}).exit, 0);
}

}  // namespace
}  // namespace driftwise::tests
