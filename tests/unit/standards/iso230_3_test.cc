#include "server/standards/iso230_3.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/standards/standards_data.h"

namespace driftwise::standards {
namespace {

using testing::HasSubstr;

TEST(Iso2303, GivesTheFiguresThatRGives) {
  const auto found = iso230_3(standards_dataset("iso230_3.csv"), {});
  ASSERT_TRUE(found) << found.error().message;
  const auto r = figures_by_r("iso230_3");
  ASSERT_EQ(found->series.size(), 3U) << "the turning point below is visited as regularly";
  EXPECT_EQ(found->series[0].side, ApproachSide::down);
  const std::pair<std::size_t, std::string> pairs[] = {{1, "low_"}, {2, "high_"}};
  for (const auto& [index, name] : pairs) {
    const DriftSeries& s = found->series[index];
    EXPECT_EQ(s.side, ApproachSide::up);
    EXPECT_EQ(s.visits, 51U);
    EXPECT_NEAR(s.range_nm, r.at(name + "range"), 1e-8);
    EXPECT_NEAR(s.at_end_nm, r.at(name + "end"), 1e-8);
    EXPECT_NEAR(s.after_60_min_nm, r.at(name + "hour"), 1e-8);
    EXPECT_NEAR(s.slope_nm_per_h, r.at(name + "slope"), 1e-8);
    ASSERT_EQ(s.windows.size(), 3U);
    for (const auto& w : s.windows)
      EXPECT_NEAR(w.range_nm, r.at(name + "window_" + std::to_string(static_cast<int>(w.minutes))),
                  1e-8);
  }
  EXPECT_GT(found->conditions.temperatures.at(0).max_degc, 23);
}

TEST(Iso2303, TakesAPositionAtRest) {
  std::vector<std::pair<double, double>> visits;
  for (int i = 0; i <= 1440; ++i) visits.emplace_back(1.25, 0.1 * i);  // every 10 s for 4 h
  const auto found = iso230_3(visits_of(visits), {});
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->series.size(), 1U);
  EXPECT_EQ(found->series[0].side, ApproachSide::unknown);
  EXPECT_NEAR(found->range_nm, 144, 1e-6);
  EXPECT_NEAR(found->series[0].slope_nm_per_h, 36, 1e-6);
  EXPECT_NEAR(found->series[0].windows[1].range_nm, 36, 1e-6) << "60 min";
}

// A drift of 1000 nm/h, visited a little more slowly than a window divides.
TEST(Iso2303, GivesARampsRangeWhereNoWindowEndsOnAVisit) {
  std::vector<std::pair<double, double>> visits;
  for (int i = 0; i < 50; ++i) visits.emplace_back(1, 1000 * 301.0 / 3600 * i);
  auto data = visits_of(visits);
  for (std::size_t row = 0; row < data.rows; ++row)
    data.time_s[row] = 301 * static_cast<double>(row);
  const auto found = iso230_3(data, {});
  ASSERT_TRUE(found) << found.error().message;
  const DriftSeries& ramp = found->series.at(0);
  ASSERT_EQ(ramp.windows.size(), 3U);
  EXPECT_NEAR(ramp.windows[0].range_nm, 250, 1e-6);
  EXPECT_NEAR(ramp.windows[1].range_nm, 1000, 1e-6);
  EXPECT_NEAR(ramp.windows[2].range_nm, 4000, 1e-6);
  EXPECT_NEAR(ramp.after_60_min_nm, 1000, 1e-6);
}

// Step of 1000 nm within the 400 s between two visits: a window of 5 min sees three quarters of it.
TEST(Iso2303, GivesAStepsShareInAWindowShorterThanTheGapBetweenVisits) {
  std::vector<std::pair<double, double>> visits;
  for (int i = 0; i < 40; ++i) visits.emplace_back(1, i < 20 ? 0 : 1000);
  auto data = visits_of(visits);
  for (std::size_t row = 0; row < data.rows; ++row)
    data.time_s[row] = 400 * static_cast<double>(row);
  const auto found = iso230_3(data, {.columns = {}, .windows_min = {5}});
  ASSERT_TRUE(found) << found.error().message;
  const DriftWindow& window = found->series.at(0).windows.at(0);
  EXPECT_NEAR(window.range_nm, 750, 1e-6);
  EXPECT_NEAR(window.from_h, 19.125 * 400 / 3600, 0.1251 * 400 / 3600);
}

// What `driftwise trajectory iso230-3 --at 1` has run: a return to zero before and after.
TEST(Iso2303, KeepsTheFirstVisitOfARestAfterAReturnToZero) {
  std::vector<std::pair<double, double>> visits = {{0, 0}};
  std::vector<double> drift_nm;
  for (int i = 0; i < 49; ++i) drift_nm.push_back(1000 * (1 - std::exp(-i / 2.0)));
  for (const double nm : drift_nm) visits.emplace_back(1, nm);
  visits.emplace_back(0, 0);
  auto data = visits_of(visits);
  data.zero.assign(data.rows, 0);
  data.zero.front() = data.zero.back() = 1;
  for (std::size_t row = 0; row < data.rows; ++row)
    data.time_s[row] = 300 * static_cast<double>(row);
  const auto found = iso230_3(data, {});
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->series.size(), 1U);
  EXPECT_EQ(found->series[0].visits, 49U);
  EXPECT_EQ(found->series[0].side, ApproachSide::unknown) << "at rest";
  EXPECT_NEAR(found->range_nm, drift_nm.back() - drift_nm.front(), 1e-6);
  EXPECT_TRUE(found->warnings.empty()) << found->warnings.front();
}

TEST(Iso2303, NamesASeriesThatIsInNoFigure) {
  auto data = standards_dataset("iso230_3.csv");
  auto& commands = const_cast<DatasetColumn*>(data.find("q1_cmd"))->values;
  commands.back() = 3.5;  // a place of its own
  const auto found = iso230_3(data, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_THAT(
      found->warnings,
      testing::ElementsAre(HasSubstr(
          "1 series of visits are in no figure: 3.5 mm from below has 1 visits, expected")));
}

// They come over the network too, where no command line has looked at them.
TEST(Iso2303, RefusesADurationThatIsNoneAndTooManyWindows) {
  const auto data = standards_dataset("iso230_3.csv");
  const auto refused = [&](auto change) {
    Iso2303Options options;
    change(options);
    const auto found = iso230_3(data, options);
    return found ? std::string("taken") : found.error().reason + ": " + found.error().message;
  };
  const double nan = std::nan("");
  for (const double minutes : {-1e6, -5.0, 0.0, nan, HUGE_VAL})
    EXPECT_THAT(refused([&](auto& o) {
                  o.windows_min = {15, minutes};
                }),
                HasSubstr("OUT_OF_RANGE: windows_min: found"))
        << minutes;
  EXPECT_THAT(refused([&](auto& o) { o.hours = 0; }), HasSubstr("OUT_OF_RANGE: hours"));
  EXPECT_THAT(refused([&](auto& o) { o.hours = nan; }), HasSubstr("OUT_OF_RANGE: hours"));
  EXPECT_THAT(refused([&](auto& o) { o.longest_gap_min = -30; }),
              HasSubstr("OUT_OF_RANGE: longest_gap_min"));
  EXPECT_THAT(refused([&](auto& o) { o.windows_min.assign(kMostWindows + 1, 15); }),
              HasSubstr("found 33 of them, expected at most 32"));
  EXPECT_EQ(refused([&](auto& o) { o.windows_min.assign(kMostWindows, 15); }), "taken");
}

TEST(Iso2303, SaysWhatALackingRunLacks) {
  const auto data = standards_dataset("iso230_3.csv");
  const auto longer = iso230_3(data, {.columns = {}, .hours = 24});
  EXPECT_EQ(longer.error().reason, "TOO_SHORT");
  EXPECT_THAT(longer.error().message, HasSubstr("needs 24 h, found 5.0"));
  EXPECT_THAT(iso230_3(data, {.columns = {}, .longest_gap_min = 5}).error().message,
              HasSubstr("has a gap of 6 min, expected at most 5 min"));
  auto untimed = data;
  untimed.time_s.clear();
  EXPECT_EQ(iso230_3(untimed, {}).error().reason, "UNTIMED");
  const auto once = iso230_3(visits_of({{0, 0}, {1, 0}, {2, 0}}), {.columns = {}, .hours = 0.001});
  EXPECT_EQ(once.error().reason, "NO_SERIES");
  EXPECT_THAT(once.error().message, HasSubstr("1 mm from below has 1 visits, expected at least 5"));
}

}  // namespace
}  // namespace driftwise::standards
