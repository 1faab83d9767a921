// What is laid over a dataset, against errors that were put into it by hand.

#include "server/correction/data_amendment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driftwise::correction {
namespace {

using effects::Call;
using effects::Power;
using effects::Term;

constexpr double kPeriodNm = 316.4;
constexpr std::int64_t kBeginNs = 1'790'000'000'000'000'000;

Term call(const std::string& effect, std::vector<std::string> symbols,
          std::vector<effects::Quantity> parameters = {}) {
  return {{Call{effect, std::move(symbols), std::move(parameters)}}};
}

// Run 3, rows 0 .. 39, 60 s apart: x_mm reads the truth and 5 nm of the interferometer's own cycle.
struct CyclicData {
  Dataset data;
  std::vector<RowOrigin> origins;
  std::vector<double> truth_mm;
};
CyclicData cyclic_data() {
  CyclicData out;
  DatasetColumn x{{"x", "mm"}, {}};
  for (int row = 0; row < 40; ++row) {
    const double truth_mm = row == 0 ? 0.0 : -2 + 0.1034 * row;
    const double phase = 2 * std::numbers::pi * truth_mm * 1e6 / kPeriodNm;
    out.truth_mm.push_back(truth_mm);
    // Counted from the zero, where the cosine was 1: as an interferometer that was zeroed there.
    x.values.push_back(truth_mm + 5e-6 * std::sin(phase) + 2e-6 * (std::cos(phase) - 1));
    out.origins.push_back({{3}, row});
    out.data.time_s.push_back(60.0 * row);
  }
  out.data.rows = 40;
  out.data.columns = {x};
  return out;
}

// What takes the cycle of cyclic_data() off again.
DataAmendment of_the_cycle() {
  DataAmendment amendment;
  amendment.shifts = {
      {"x",
       {call("sin", {"x"}, {{kPeriodNm, "nm"}}), call("cos", {"x"}, {{kPeriodNm, "nm"}})},
       {5e-6, 2e-6},
       {},
       {}}};
  return amendment;
}

TEST(DataAmendment, GivesBackTheLengthThatTheInterferometersCycleWasLaidOver) {
  auto data = cyclic_data();
  ASSERT_TRUE(amend(of_the_cycle(), data.origins, {kBeginNs}, data.data));
  // The phase is read off the length in error: 5.4 nm of 316 turn it by 0.11 rad, 0.6 nm at most.
  for (int row = 0; row < 40; ++row)
    EXPECT_NEAR(data.data.columns[0].values[static_cast<std::size_t>(row)],
                data.truth_mm[static_cast<std::size_t>(row)], 0.7e-6)
        << row;
}

// The zero is where the pose is zero, also when no row of the datum was measured there.
TEST(DataAmendment, CountsAPeriodicErrorFromPoseZeroWhereverTheDatumBegins) {
  auto data = cyclic_data();
  data.data.columns[0].values.erase(data.data.columns[0].values.begin());
  data.data.time_s.erase(data.data.time_s.begin());
  data.truth_mm.erase(data.truth_mm.begin());
  data.origins.erase(data.origins.begin());
  data.data.rows = 39;
  ASSERT_TRUE(amend(of_the_cycle(), data.origins, {kBeginNs}, data.data));
  for (std::size_t row = 0; row < 39; ++row)
    EXPECT_NEAR(data.data.columns[0].values[row], data.truth_mm[row], 0.7e-6) << row;
}

// A plunger that sticks stays 150 nm short of where it was pushed, up and down.
TEST(DataAmendment, GivesBackTheLengthBehindWhichATouchingProbeLags) {
  CyclicData data;
  DatasetColumn x{{"x", "mm"}, {}};
  double plunger_mm = -150e-6;
  for (int row = 0; row < 40; ++row) {
    const double truth_mm = 0.01 * (row % 20 < 10 ? row % 20 : 19.5 - row % 20);
    plunger_mm = std::clamp(plunger_mm, truth_mm - 150e-6, truth_mm + 150e-6);
    data.truth_mm.push_back(truth_mm);
    x.values.push_back(plunger_mm);
    data.origins.push_back({{3}, row});
    data.data.time_s.push_back(60.0 * row);
  }
  data.data.rows = 40;
  data.data.columns = {x};
  DataAmendment amendment;
  amendment.shifts = {{"x", {call("play", {"x"}, {{300, "nm"}})}, {1}, {}, {}}};
  ASSERT_TRUE(amend(amendment, data.origins, {kBeginNs}, data.data));
  const auto& read_mm = data.data.columns[0].values;
  for (std::size_t row = 2; row < 40; ++row)
    EXPECT_NEAR(read_mm[row] - read_mm[1], data.truth_mm[row] - data.truth_mm[1], 1e-9) << row;
}

TEST(DataAmendment, CorrectsALengthInItsOwnUnit) {
  auto data = cyclic_data();
  auto& x = data.data.columns[0];
  x.channel.unit = "um";
  for (double& value : x.values) value *= 1e3;
  DatasetColumn pressure{{"pressure", "hPa"}, {}};
  for (int row = 0; row < 40; ++row) pressure.values.push_back(1000 + row);
  data.data.columns.push_back(pressure);
  const auto before = data.data.columns[0].values;
  DataAmendment amendment;
  amendment.shifts = {{"x", {{{Power{"pressure", 1}}}}, {1e-6}, {}, {}}};
  ASSERT_TRUE(amend(amendment, data.origins, {kBeginNs}, data.data));
  EXPECT_NEAR(before[10] - data.data.columns[0].values[10], 0.010, 1e-9) << "10 nm in um";
}

TEST(DataAmendment, CountsFromTheZeroOfEachDatum) {
  auto data = cyclic_data();
  for (int row = 0; row < 40; ++row) data.data.datum.push_back(row < 20 ? 7 : 8);
  DatasetColumn pressure{{"pressure", "hPa"}, {}};
  for (int row = 0; row < 40; ++row) pressure.values.push_back(1000 + row);
  data.data.columns.push_back(pressure);
  const auto before = data.data.columns[0].values;
  DataAmendment amendment;
  amendment.shifts = {{"x", {{{Power{"pressure", 1}}}}, {1e-6}, {}, {}}};
  ASSERT_TRUE(amend(amendment, data.origins, {kBeginNs}, data.data));
  const auto shift_nm = [&](std::size_t row) {
    return (before[row] - data.data.columns[0].values[row]) * 1e6;
  };
  EXPECT_NEAR(shift_nm(0), 0, 1e-9);
  EXPECT_NEAR(shift_nm(19), 19, 1e-6);
  EXPECT_NEAR(shift_nm(20), 0, 1e-9);  // zeroed again
  EXPECT_NEAR(shift_nm(30), 10, 1e-6);
}

TEST(DataAmendment, CountsFromTheFirstRowThatHasTheReading) {
  auto data = cyclic_data();
  DatasetColumn t{{"t05", "degC"}, {}};
  for (int row = 0; row < 40; ++row) t.values.push_back(row < 2 ? kMissing : 20 + 0.1 * row);
  data.data.columns.push_back(t);
  const auto before = data.data.columns[0].values;
  DataAmendment amendment;
  amendment.shifts = {{"x", {{{Power{"t05", 1}}}}, {1e-4}, {}, {}}};  // 100 nm/K
  ASSERT_TRUE(amend(amendment, data.origins, {kBeginNs}, data.data));
  const auto shift_nm = [&](std::size_t row) {
    return (before[row] - data.data.columns[0].values[row]) * 1e6;
  };
  EXPECT_NEAR(shift_nm(2), 0, 1e-6) << "not 100 nm/K of 20 degC";
  EXPECT_NEAR(shift_nm(12), 100, 1e-6);
  EXPECT_TRUE(is_missing(data.data.columns[0].values[0])) << "what it is there cannot be known";
}

TEST(DataAmendment, ADriftHoldsForTheRunsItWasFoundInByTheirOwnClock) {
  auto data = cyclic_data();
  for (std::size_t row = 20; row < 40; ++row) data.origins[row].run = {4};
  const auto before = data.data.columns[0].values;
  DataAmendment amendment;
  // Found in data that began an hour earlier: 10 nm an hour there.
  amendment.shifts = {
      {"x", {call("drift", {})}, {10e-6}, {RunId{3}}, {kBeginNs - 3'600'000'000'000}}};
  ASSERT_TRUE(amend(amendment, data.origins, {kBeginNs}, data.data));
  EXPECT_NEAR((before[18] - data.data.columns[0].values[18]) * 1e6, 10 * 18 / 60.0, 1e-6);
  EXPECT_EQ(data.data.columns[0].values[25], before[25]);  // run 4 is another day
}

// A drift alone would not tell: it counts from the zero, whatever the clock says there.
TEST(DataAmendment, AJumpStandsAtItsInstantOfTheClockItWasFoundBy) {
  auto data = cyclic_data();
  const auto before = data.data.columns[0].values;
  DataAmendment amendment;
  // 4500 s after a beginning that was an hour before this one: 900 s, row 15.
  amendment.shifts = {{"x",
                       {call("step", {}, {{4500, "s"}})},
                       {20e-6},
                       {RunId{3}},
                       {kBeginNs - 3'600'000'000'000}}};
  ASSERT_TRUE(amend(amendment, data.origins, {kBeginNs}, data.data));
  const auto shift_nm = [&](std::size_t row) {
    return (before[row] - data.data.columns[0].values[row]) * 1e6;
  };
  EXPECT_NEAR(shift_nm(14), 0, 1e-9);
  EXPECT_NEAR(shift_nm(15), 20, 1e-6);
  EXPECT_NEAR(shift_nm(39), 20, 1e-6);
}

TEST(DataAmendment, LeavesRowsOfAFileAloneUnlessItNamesTheirRun) {
  auto file = cyclic_data();
  for (auto& origin : file.origins) origin.of_file = true;
  DataAmendment amendment;
  amendment.shifts.resize(1);
  amendment.shifts[0].axis = "x";
  amendment.shifts[0].terms = {{{Power{"x", 1}}}};
  amendment.shifts[0].mm = {1e-3};
  const auto before = file.data.find("x")->values;
  ASSERT_TRUE(amend(amendment, file.origins, {}, file.data));
  EXPECT_EQ(file.data.find("x")->values, before);
  amendment.shifts[0].runs = {RunId{3}};
  ASSERT_TRUE(amend(amendment, file.origins, {}, file.data));
  EXPECT_NE(file.data.find("x")->values, before);
}

TEST(DataAmendment, LeavesALengthAloneWhenItsChannelIsNotThere) {
  auto data = cyclic_data();
  const auto before = data.data.columns[0].values;
  DataAmendment amendment;
  amendment.shifts = {{"x", {{{Power{"ry", 1}}}}, {1e-3}, {}, {}}};
  ASSERT_TRUE(amend(amendment, data.origins, {kBeginNs}, data.data));
  EXPECT_EQ(data.data.columns[0].values, before);
}

TEST(DataAmendment, SplitsADatumFromARowOn) {
  auto data = cyclic_data();
  DataAmendment amendment;
  amendment.splits = {{{3}, 25}, {{9}, 1}};  // run 9 is not in this dataset
  ASSERT_TRUE(amend(amendment, data.origins, {kBeginNs}, data.data));
  ASSERT_EQ(data.data.datum.size(), 40u);
  EXPECT_EQ(data.data.datum[24], 0);
  EXPECT_NE(data.data.datum[25], 0);
  EXPECT_EQ(data.data.datum[39], data.data.datum[25]);
}

TEST(DataAmendment, SplitsThatDatumOnlyAndEachSplitIsADatumOfItsOwn) {
  auto data = cyclic_data();
  for (int row = 0; row < 40; ++row) data.data.datum.push_back(row < 30 ? 7 : 8);
  DataAmendment amendment;
  amendment.splits = {{{3}, 10}, {{3}, 20}};
  ASSERT_TRUE(amend(amendment, data.origins, {kBeginNs}, data.data));
  const auto& datum = data.data.datum;
  EXPECT_EQ(datum[9], 7);
  EXPECT_EQ(datum[30], 8) << "zeroed again: the jump is behind it";
  EXPECT_EQ(datum[39], 8);
  for (const auto fresh : {datum[10], datum[20]}) {
    EXPECT_NE(fresh, 7);
    EXPECT_NE(fresh, 8);
  }
  EXPECT_NE(datum[10], datum[20]);
  EXPECT_EQ(datum[19], datum[10]);
  EXPECT_EQ(datum[29], datum[20]);
}

TEST(DataAmendment, LeavesASensorOutOfTheRunsInWhichItLied) {
  auto data = cyclic_data();
  data.data.columns.push_back({{"t07", "degC"}, std::vector<double>(40, 20.5)});
  DataAmendment other, this_one;
  other.sensors = {{{9}, "t07"}};
  this_one.sensors = {{{3}, "t07"}};
  ASSERT_TRUE(amend(other, data.origins, {kBeginNs}, data.data));
  EXPECT_NE(data.data.find("t07"), nullptr);
  ASSERT_TRUE(amend(this_one, data.origins, {kBeginNs}, data.data));
  EXPECT_EQ(data.data.find("t07"), nullptr);
}

}  // namespace
}  // namespace driftwise::correction
