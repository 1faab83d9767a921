// From a trajectory file to a dataset and a model, through the command line.

#include <gmock/gmock.h>

#include <regex>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

constexpr int kLines = 3, kPerLine = 6, kCampaignRows = kLines * kPerLine;
constexpr const char* kFormula = "q ~ x + x^2 + t05..t10";

// A fit's JSON without what tells two equal fits apart: how long it took, under which number it is
// kept, and what limits it, which is said with the rows at hand.
std::string comparable(const std::string& fit) {
  const auto plain =
      std::regex_replace(fit, std::regex(",?\\s*\"(fit_us|model_id)\":\\s*[0-9.e+-]+"), "");
  return std::regex_replace(plain, std::regex(",?\\s*\"limited_by\":\\s*\\[[^\\]]*\\]"), "");
}

void expect_the_same_fit_from_the_file(const CellAtWork& cell, const std::string& run,
                                       const std::vector<std::string>& options = {}) {
  const std::string file = cell.folder() + "/run.csv";
  cell.say({"data", "export", run, "-o", file});
  std::vector<std::string> of_file = {"fit", file, "--model", kFormula, "--json"};
  std::vector<std::string> of_run = {"fit", "--run", run, "--model", kFormula, "--json"};
  of_file.insert(of_file.end(), options.begin(), options.end());
  of_run.insert(of_run.end(), options.begin(), options.end());
  const auto from_file = comparable(cell.say(of_file));
  const auto from_daemon = comparable(cell.say(of_run));
  EXPECT_EQ(from_file, from_daemon);
  EXPECT_THAT(from_file, testing::HasSubstr("\"coefficient\""));
}

TEST(Campaign, MeasuresEveryPointWithItsTemperatures) {
  CellAtWork cell;
  cell.start_daemon();
  const auto trajectory = cell.write("short.csv", campaign(kLines, kPerLine));
  const auto watched = cell.cli({"run", "start", trajectory, "--watch"});
  EXPECT_EQ(watched.code, 0) << watched.err;

  const auto run = cell.run(1);
  EXPECT_EQ(run.at("state"), "done");
  EXPECT_EQ(run.at("accepted_count"), kCampaignRows);
  const auto points = cell.ask({"run", "points", "1"});
  const auto& list = points.is_array() ? points : points.at("points");
  ASSERT_EQ(list.size(), static_cast<std::size_t>(kCampaignRows));
  for (const auto& point : list) {
    const auto& values = point.at("values");
    for (int t = 1; t <= 10; ++t) {
      const auto channel = std::string(t < 10 ? "t0" : "t") + std::to_string(t) + "_degC";
      ASSERT_TRUE(values.contains(channel)) << channel << " in " << point;
      EXPECT_GT(values.at(channel).get<double>(), 15.0);
      EXPECT_LT(values.at(channel).get<double>(), 30.0);
    }
    for (const char* channel : {"air_degC", "support_degC", "x_mm", "x_std_nm"})
      EXPECT_TRUE(values.contains(channel)) << channel;
    EXPECT_NEAR(values.at("x_mm").get<double>(), values.at("q1_mm").get<double>(), 0.01);
  }
  // Four readings of the interferometer stand behind each accepted attempt.
  EXPECT_EQ(cell.count("SELECT count(*) FROM reading JOIN attempt USING (attempt_id) "
                       "JOIN device USING (device_id) "
                       "WHERE verdict = 'accepted' AND device.name = 'laser-x'"),
            4 * kCampaignRows);

  expect_the_same_fit_from_the_file(cell, "1");
  expect_the_same_fit_from_the_file(
      cell, "1",
      {"--criterion", "bic", "--hierarchy", "--starts", "4", "--seed", "3", "--force", "t07",
       "--without", "x^2", "--exclude", "t05", "--blocks", "4", "--offers"});
  // Rows that a person keeps out are out of both, and the rows are back when he puts them back.
  cell.say({"data", "exclude", "1", "--rows", "2,7-8", "--reason", "the door stood open"});
  expect_the_same_fit_from_the_file(cell, "1");
  EXPECT_THAT(cell.say({"fit", "--run", "1", "--model", kFormula, "--json"}),
              testing::HasSubstr("\"excluded\":3"));
  cell.say({"data", "restore", "1", "--rows", "1-18", "--reason", "it did not"});
  EXPECT_THAT(cell.say({"fit", "--run", "1", "--model", kFormula, "--json"}),
              testing::HasSubstr("\"excluded\":0"));
}

TEST(Campaign, FindsItsDevicesBeforeARunNeedsThem) {
  CellAtWork cell;
  cell.start_daemon();
  const auto listed = cell.ask({"devices"});
  const auto& devices = listed.is_array() ? listed : listed.at("devices");
  ASSERT_FALSE(devices.empty());
  for (const auto& device : devices) EXPECT_EQ(device.at("link"), "connected") << device;
}

TEST(Campaign, ComesBackToTheByteWhenItsExportIsImported) {
  CellAtWork cell;
  cell.start_daemon();
  ASSERT_EQ(cell.end_of(cell.start_run(campaign(1, 6))).at("state"), "done");
  const auto exported = cell.say({"data", "export", "1"});
  const auto imported = cell.ask({"data", "import", cell.write("exported.csv", exported)});
  EXPECT_EQ(imported.at("state"), "done");
  EXPECT_EQ(cell.say({"data", "export", std::to_string(imported.at("id").get<int>())}), exported);
}

TEST(Campaign, GoesOnInANewDatumWhenTheBeamWasBroken) {
  CellAtWork cell;
  cell.start_daemon();
  const auto run = cell.start_run(campaign(5, 6));
  cell.wait_for_points(8);
  cell.control("fault break-beam");
  const auto ended = cell.end_of(run);
  EXPECT_EQ(ended.at("state"), "done") << ended;
  EXPECT_EQ(ended.at("accepted_count"), 30);
  EXPECT_EQ(cell.count("SELECT count(*) FROM datum WHERE run_id = 1"), 2);
  EXPECT_EQ(cell.sql("SELECT reason FROM datum ORDER BY datum_id DESC LIMIT 1"), "beam lost");
  EXPECT_GE(cell.count("SELECT count(*) FROM event WHERE what = 'run.trouble' AND run_id = 1"), 1);
  // No point took its length from before and after the new zero: each stands in its own datum.
  EXPECT_EQ(cell.count("SELECT count(DISTINCT datum_id) FROM point"), 2);
  // The second datum is a constant of its own in both programs' fits.
  expect_the_same_fit_from_the_file(cell, "1");
}

}  // namespace
}  // namespace driftwise::tests
