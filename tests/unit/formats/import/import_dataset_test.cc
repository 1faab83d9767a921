#include "server/formats/import/import_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "server/formats/csv/dataset_csv.h"
#include "server/formats/import/mapping_file.h"
#include "server/formats/text/text.h"
#include "tests/unit/formats/import/gzipped.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;

constexpr const char* kTwoColumns =
    "[file]\nseparator = \";\"\ndecimal = \",\"\n"
    "[[column]]\nsource = \"pos\"\nunit = \"m\"\nchannel = \"x_mm\"\n"
    "[[column]]\nsource = \"temp\"\nunit = \"K\"\nchannel = \"t01_degC\"\n";

ImportMapping mapping_of(const std::string& toml) {
  auto mapping = read_import_mapping(toml, "map.toml");
  EXPECT_TRUE(mapping) << mapping.error().message;
  return mapping ? std::move(*mapping) : ImportMapping{};
}

ImportedDataset imported(const std::string& text, const std::string& toml) {
  auto out = import_dataset(text, "lab.csv", mapping_of(toml));
  EXPECT_TRUE(out) << out.error().message;
  return out ? std::move(*out) : ImportedDataset{};
}

Error refused(const std::string& text, const std::string& toml) {
  const auto out = import_dataset(text, "lab.csv", mapping_of(toml));
  EXPECT_FALSE(out);
  return out ? Error{} : out.error();
}

TEST(ImportDataset, ConvertsUnitsExactlyAndNamesChannels) {
  const auto out = imported("pos;temp\n0,762898;293,15\n-1,5;294,15\n", kTwoColumns);
  EXPECT_EQ(out.dataset.find("x")->values, (std::vector<double>{762.898, -1500}));
  EXPECT_NEAR(out.dataset.find("t01")->values[1], 21, 1e-12);
  EXPECT_EQ(out.report.columns[0].first, "0,762898");
  EXPECT_EQ(out.report.columns[0].max, 762.898);
}

// 0.018 degF of spread are 0.01 K by definition of the degree; a temperature of 68 degF is 20 degC.
TEST(ImportDataset, ConvertsASpreadByItsFactorAlone) {
  const std::string map =
      "[[column]]\nsource = \"T\"\nunit = \"degF\"\nchannel = \"t01_degC\"\n"
      "[[column]]\nsource = \"Ts\"\nunit = \"degF\"\nchannel = \"t01_std_degC\"\n"
      "[[column]]\nsource = \"Tk\"\nunit = \"K\"\nchannel = \"t02_std_degC\"\n";
  const auto out = imported("T,Ts,Tk\n68,0.018,0.02\n69.8,0.036,0.03\n", map);
  EXPECT_NEAR(out.dataset.find("t01")->values[0], 20, 1e-12);
  EXPECT_NEAR(out.dataset.find("t01_std")->values[0], 0.01, 1e-15);
  EXPECT_NEAR(out.dataset.find("t01_std")->values[1], 0.02, 1e-15);
  EXPECT_EQ(out.dataset.find("t02_std")->values, (std::vector<double>{0.02, 0.03}));
  const auto error = refused("T,Ts,Tk\n68,0.018,0.02\n69.8,-0.036,0.03\n", map);
  EXPECT_EQ(error.reason, "BAD_NUMBER");
  EXPECT_THAT(error.message, HasSubstr("lab.csv:3: "));
  EXPECT_THAT(error.message, HasSubstr("found '-0.036', expected 0 or more"));
}

TEST(ImportDataset, ReadsTheSameTableInEveryDress) {
  const std::string plain = "pos;temp\n0,5;293,15\n";
  const auto expected = write_dataset_csv(imported(plain, kTwoColumns).dataset);
  const auto body = [](const std::string& csv) { return csv.substr(csv.find("x_mm")); };
  for (const std::string& dressed :
       {std::string("\xEF\xBB\xBFpos;temp\r\n0,5;293,15\r\n"), tests::gzipped(plain),
        std::string("# made by hand\n\npos ; temp\n 0,5;\"293,15\"")})
    EXPECT_EQ(body(write_dataset_csv(imported(dressed, kTwoColumns).dataset)), body(expected));
}

TEST(ImportDataset, SaysThatACompressedFileWithNothingInItHasNoRows) {
  for (const std::string& empty : {tests::gzipped(""), std::string()}) {
    const auto error = refused(empty, kTwoColumns);
    EXPECT_EQ(error.reason, "NO_HEADER");
    EXPECT_THAT(error.message, HasSubstr("found no row of a table"));
  }
}

TEST(ImportDataset, RefusesASlipInTheMetadataThatItsReaderWouldRefuse) {
  const std::string text = "pos;temp\n0,5;293,15\n", mapping = kTwoColumns;
  const auto error = refused(text, mapping + "[metadata]\nparts = \"to1=robot\"\n");
  EXPECT_EQ(error.reason, "BAD_METADATA");
  EXPECT_THAT(error.message, HasSubstr("map.toml: [metadata] parts: found 'to1=robot'"));
  EXPECT_THAT(error.message, HasSubstr("did you mean t01?"));
  EXPECT_EQ(refused(text, mapping + "[metadata]\noverruns = \"true\"\n").reason, "BAD_METADATA");
  const auto out = imported(text, mapping + "[metadata]\nparts = \"t01=robot\"\n");
  EXPECT_TRUE(read_dataset_csv(write_dataset_csv(out.dataset), "out.csv"));
}

TEST(ImportDataset, TakesColumnsByNumberWhereThereIsNoHeader) {
  const auto out = imported("7 1.5\n8 2.5\n",
                            "[file]\nseparator = \"blanks\"\nheader = false\n"
                            "[[column]]\nsource = 2\nchannel = \"x_mm\"\n");
  EXPECT_EQ(out.dataset.find("x")->values, (std::vector<double>{1.5, 2.5}));
  EXPECT_EQ(out.report.unused, std::vector<std::string>{"column 1"});
}

TEST(ImportDataset, TakesNoMeasurementForAHeader) {
  const std::string columns =
      "[[column]]\nsource = 1\nchannel = \"q1_mm\"\n[[column]]\nsource = 2\nchannel = \"x_mm\"\n";
  const auto error = refused("1.0,1.1\n2.0,2.1\n", columns);
  EXPECT_EQ(error.reason, "NO_HEADER");
  EXPECT_THAT(error.message, HasSubstr("lab.csv:1: column 1 of the mapping: found '1.0'"));
  EXPECT_THAT(error.message, HasSubstr("header = false"));
  // numpy.savetxt: its header is a comment, unless another mark is named.
  EXPECT_THAT(refused("# q,x\n1.0,1.1\n2.0,2.1\n", columns).message, HasSubstr("comment = "));
  EXPECT_EQ(imported("# q,x\n1.0,1.1\n", "[file]\ncomment = \"%\"\n" + columns).dataset.rows, 1u);
  EXPECT_EQ(imported("1.0,1.1\n", "[file]\nheader = false\n" + columns).dataset.rows, 1u);
  EXPECT_EQ(
      imported("q,2\n1.0,1.1\n", "[[column]]\nsource = 1\nchannel = \"q1_mm\"\n").dataset.rows, 1u)
      << "a name that no rule uses";
}

TEST(ImportDataset, ScalesAndShiftsBeforeItConverts) {
  const auto out = imported("raw\n100\n",
                            "[[column]]\nsource = \"raw\"\nunit = \"V\"\nscale = -0.01\n"
                            "offset = 2\nchannel = \"bridge_V\"\n[constants]\nforce_N = 2.305\n");
  EXPECT_EQ(out.dataset.columns[0].values[0], 1.0);
  EXPECT_EQ(out.dataset.find("force")->values[0], 2.305);
}

TEST(ImportDataset, FillsTheDatasetsOwnColumns) {
  const auto out =
      imported("n,r,z,wait\n3,7,1,200\n3,7,0,\n",
               "[[column]]\nsource = \"n\"\nchannel = \"line\"\n"
               "[[column]]\nsource = \"r\"\nchannel = \"run\"\n"
               "[[column]]\nsource = \"z\"\nchannel = \"zero\"\n"
               "[[column]]\nsource = \"wait\"\nunit = \"ms\"\nchannel = \"dwell_s\"\n");
  EXPECT_EQ(out.dataset.line, (std::vector<std::int64_t>{3, 3}));
  EXPECT_EQ(out.dataset.run[0], 7);
  EXPECT_EQ(out.dataset.zero, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(out.dataset.dwell_s[0], 0.2);
  EXPECT_TRUE(is_missing(out.dataset.dwell_s[1]));
}

TEST(ImportDataset, TakesTheSpellingsOfMissingThatTheMappingLists) {
  const std::string toml =
      "[file]\nmissing = [\"\", \"n/a\", \"-999\"]\n"
      "[[column]]\nsource = \"x\"\nchannel = \"x_mm\"\n";
  const auto out = imported("x\nn/a\n-999\n5\n", toml);
  EXPECT_EQ(out.report.columns[0].missing, 2U);
  EXPECT_EQ(out.dataset.columns[0].values[2], 5);
  EXPECT_EQ(refused("x\nNaN\n", toml).reason, "BAD_NUMBER");
}

TEST(ImportDataset, LeavesRowsOutByRuleAndCountsThem) {
  const auto out = imported("x,q\n1,ok\n2,bad\n,ok\n900,ok\n3,ok\n",
                            "[[column]]\nsource = \"x\"\nchannel = \"x_mm\"\n"
                            "[[drop]]\ncolumn = \"q\"\nequals = \"bad\"\nwhy = \"beam broken\"\n"
                            "[[drop]]\ncolumn = \"x\"\nmissing = true\nwhy = \"nothing measured\"\n"
                            "[[drop]]\ncolumn = 1\nabove = 100\nwhy = \"out of range\"\n");
  EXPECT_EQ(out.dataset.columns[0].values, (std::vector<double>{1, 3}));
  EXPECT_EQ(out.report.rows_read, 5U);
  EXPECT_EQ(out.report.dropped[0].lines, std::vector<std::size_t>{3});
  EXPECT_EQ(out.report.dropped[1].rows, 1U);
  EXPECT_EQ(out.report.dropped[2].lines, std::vector<std::size_t>{5});
  EXPECT_THAT(write_dataset_csv(out.dataset), HasSubstr("# dropped: 1 rows: beam broken\n"));
}

constexpr const char* kTimed =
    "[[column]]\nsource = \"x\"\nchannel = \"x_mm\"\n"
    "[time]\ncolumn = \"t\"\nformat = \"iso8601\"\n";

TEST(ImportDataset, CountsTimeFromTheFirstRow) {
  const auto out = imported("t,x\n2026-11-21T08:00:00Z,1\n2026-11-21T08:00:29.5Z,2\n", kTimed);
  EXPECT_EQ(out.dataset.time_s, (std::vector<double>{0, 29.5}));
  EXPECT_EQ(out.report.time_zero, "2026-11-21T08:00:00Z");
}

TEST(ImportDataset, SortsRowsThatStandAtTheEndOfTheFile) {
  const std::string text =
      "t,x\n2026-11-21T08:00:00Z,1\n2026-11-21T09:00:00Z,3\n"
      "2026-11-21T08:30:00Z,2\n";
  EXPECT_THAT(refused(text, kTimed).message,
              HasSubstr("lab.csv:4: found the time 2026-11-21T08:30:00Z after "
                        "2026-11-21T09:00:00Z in line 3"));
  const auto out = imported(text, std::string(kTimed) + "order = \"by-time\"\n");
  EXPECT_EQ(out.dataset.columns[0].values, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(out.report.late_rows, 1U);
}

// Every 10 min from midnight to 4 h, the hour from 2 to 3 twice; the rows after `to` are left
// out.
std::string autumn_night(const std::string& zone, int to = 30) {
  std::string csv = "when;q\n";
  for (int i = 0; i < to; ++i) {
    const int minute = 10 * (i < 18 ? i : i - 6);
    csv += "2026-10-25 0" + std::to_string(minute / 60) + ":" + std::to_string(minute % 60 / 10) +
           "0:00" + zone + ";" + std::to_string(i) + "\n";
  }
  return csv;
}

TEST(ImportDataset, SaysWhereTheClockWasSetBackAndSortsNothing) {
  for (const std::string order : {"as-it-is", "by-time"})
    for (const std::string format : {"%Y-%m-%d %H:%M:%S", "iso8601"}) {
      const std::string mapping =
          "[file]\nseparator = \";\"\n[time]\ncolumn = \"when\"\nformat = \"" + format +
          "\"\norder = \"" + order +
          "\"\nequal_times = \"spread\"\nresolution_s = 1\nutc_offset_h = 2\n"
          "[[column]]\nsource = \"q\"\nchannel = \"q1_mm\"\n";
      const auto error = refused(autumn_night(""), mapping);
      EXPECT_EQ(error.reason, "TIME_NOT_INCREASING");
      EXPECT_THAT(error.message, HasSubstr("lab.csv:20: "));
      EXPECT_THAT(error.message, HasSubstr("the clock may have been set back here (summer time?)"));
      if (format != "iso8601" || order != "by-time") continue;
      // A stamp with its zone is no local time.
      EXPECT_EQ(imported(autumn_night("+02:00"), mapping).report.late_rows, 5u);
      // Four rows of the second hour could be late ones or not: nobody knows.
      EXPECT_THAT(refused(autumn_night("", 22), mapping).message, HasSubstr("summer time?"));
    }
}

// Rows of any spacing from 1 to 5 h of the night in which 3 h becomes 2 h again; of 60 min one
// stamp is there twice, of 45 min the step back is of 15.
TEST(ImportDataset, SeesTheClockSetBackWhateverTheSpacingOfTheRows) {
  for (const int step_min : {1, 5, 13, 20, 30, 31, 45, 59, 60})
    for (const std::string order : {"as-it-is", "by-time"}) {
      SCOPED_TRACE(std::to_string(step_min) + " min, " + order);
      std::string csv = "t,x\n";
      for (int real_min = 60; real_min < 360; real_min += step_min) {
        const int local_min = real_min < 180 ? real_min : real_min - 60;
        const std::string minute = std::to_string(100 + local_min % 60).substr(1);
        csv += "2020-10-25T0" + std::to_string(local_min / 60) + ":" + minute + ":00," +
               std::to_string(real_min) + "\n";
      }
      const auto error = refused(csv, std::string(kTimed) + "order = \"" + order +
                                          "\"\nequal_times = \"spread\"\nresolution_s = 60\n");
      EXPECT_EQ(error.reason, "TIME_NOT_INCREASING");
      EXPECT_THAT(error.message, HasSubstr("utc_offset_h"));
      EXPECT_THAT(error.message, testing::Not(HasSubstr("sorts the rows")));
    }
}

// Stamps of a clock that goes back by `early_s` two hours before summer time ends, one row every
// 61 s from 0 to 6 h; late_row: one that stands 90 s behind the next, an hour after.
std::string night_with_a_clock_set_right(int early_s, bool late_row,
                                         const std::string& day = "2026-10-25") {
  std::vector<std::string> rows;
  for (int i = 0; i < 350; ++i) {
    const int real_s = 61 * i;
    const int local_s = real_s - (real_s >= 3 * 3600 ? 3600 : 0) + (real_s < 3600 ? early_s : 0);
    const auto two = [](int value) { return std::to_string(100 + value).substr(1); };
    rows.push_back(day + "T" + two(local_s / 3600) + ":" + two(local_s / 60 % 60) + ":" +
                   two(local_s % 60) + "," + std::to_string(i) + "\n");
  }
  if (late_row) std::rotate(rows.begin() + 250, rows.begin() + 251, rows.begin() + 253);
  std::string csv = "t,x\n";
  for (const auto& row : rows) csv += row;
  return csv;
}

// 3 h is 177 rows of 61 s: the row in line 180 is the first of winter.
TEST(ImportDataset, SeesTheClockSetBackWhateverOtherStepsBackTheFileHas) {
  for (const int early_s : {0, 63, 200})
    for (const bool late_row : {false, true})
      for (const std::string order : {"as-it-is", "by-time"}) {
        SCOPED_TRACE(std::to_string(early_s) + (late_row ? " s, late row, " : " s, ") + order);
        const auto error = refused(night_with_a_clock_set_right(early_s, late_row),
                                   std::string(kTimed) + "order = \"" + order + "\"\n");
        EXPECT_EQ(error.reason, "TIME_NOT_INCREASING");
        EXPECT_THAT(error.message, HasSubstr("lab.csv:180: "));
        EXPECT_THAT(error.message, HasSubstr("the one such step in the file"));
        EXPECT_THAT(error.message, HasSubstr("summer time?"));
        EXPECT_THAT(error.message, testing::Not(HasSubstr("by-time")));
      }
}

// Days of the tz database on which clocks of Africa/Casablanca go from 3 h back to 2 h (Ramadan),
// and one of America/Sao_Paulo.
TEST(ImportDataset, SeesTheClockSetBackInAnyMonth) {
  for (const char* day : {"2026-02-15", "2029-01-14", "2031-12-14", "2019-02-17"})
    for (const int early_s : {0, 63}) {
      SCOPED_TRACE(std::string(day) + ", " + std::to_string(early_s));
      const auto error = refused(night_with_a_clock_set_right(early_s, true, day),
                                 std::string(kTimed) + "order = \"by-time\"\n");
      EXPECT_EQ(error.reason, "TIME_NOT_INCREASING");
      EXPECT_THAT(error.message, HasSubstr("lab.csv:180: "));
      EXPECT_THAT(error.message, HasSubstr("the one such step in the file"));
    }
}

// Three series of twenty minutes, the latest first: each step back is of 50 min, and no time is
// there twice. The day is one of clocks that are set back.
TEST(ImportDataset, SortsSeriesThatWereJoinedOutOfOrder) {
  std::string csv = "t,x\n";
  for (const int begin_min : {11 * 60 + 20, 10 * 60 + 50, 10 * 60 + 20})
    for (int minute = begin_min; minute <= begin_min + 20; minute += 5)
      csv += "2026-10-25T" + std::to_string(minute / 60) + ":" +
             std::to_string(100 + minute % 60).substr(1) + ":00," + std::to_string(minute) + "\n";
  const auto out = imported(csv, std::string(kTimed) + "order = \"by-time\"\n");
  EXPECT_EQ(out.report.late_rows, 10u);
  EXPECT_TRUE(std::ranges::is_sorted(out.dataset.columns[0].values));
}

// Rows every 20 s, with a pause over lunch of 50 min, and two that are 3 s and 8 s late: a pause
// does not make an hour of the clock out of them.
TEST(ImportDataset, SortsLateLocalRowsOfAFileWithAPause) {
  const auto out = imported(
      "t,x\n2026-10-25T11:00:00,1\n2026-10-25T11:00:20,2\n2026-10-25T11:00:43,4\n"
      "2026-10-25T11:00:40,3\n2026-10-25T11:01:00,5\n2026-10-25T11:51:00,6\n"
      "2026-10-25T11:51:28,8\n2026-10-25T11:51:20,7\n2026-10-25T11:51:40,9\n",
      std::string(kTimed) + "order = \"by-time\"\n");
  EXPECT_EQ(out.report.late_rows, 2u);
  EXPECT_EQ(out.dataset.columns[0].values, (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

// Nor is a row that a logger wrote a second late an hour of the clock.
TEST(ImportDataset, SortsALocalRowThatIsTooLittleLateForAClockSetBack) {
  const std::string text =
      "t,x\n2020-10-25T08:00:00,1\n2020-10-25T08:00:02,3\n2020-10-25T08:00:01,2\n"
      "2020-10-25T08:00:03,4\n";
  EXPECT_EQ(imported(text, std::string(kTimed) + "order = \"by-time\"\n").report.late_rows, 1u);
}

TEST(ImportDataset, SpreadsRowsOfOneStampOnlyWhenAsked) {
  const std::string text = "t,x\n10,1\n10,2\n10,3\n10,4\n11,5\n";
  const std::string toml =
      "[[column]]\nsource = \"x\"\nchannel = \"x_mm\"\n[time]\ncolumn = \"t\"\nformat = "
      "\"seconds\"\n";
  EXPECT_THAT(refused(text, toml).message, HasSubstr("equal_times"));
  const auto out = imported(text, toml + "equal_times = \"spread\"\n");
  EXPECT_EQ(out.dataset.time_s, (std::vector<double>{10, 10.25, 10.5, 10.75, 11}));
  EXPECT_EQ(out.report.spread_rows, 3U);
  EXPECT_EQ(refused(text, toml + "equal_times = \"spread\"\nresolution_s = 2\n").reason,
            "TIME_NOT_INCREASING");
}

TEST(ImportDataset, JoinsADateAndATime) {
  const auto out = imported("d,t,x\n21.11.2026,08:00:00,1\n21.11.2026,08:00:05,2\n",
                            "[[column]]\nsource = \"x\"\nchannel = \"x_mm\"\n[time]\n"
                            "columns = [\"d\", \"t\"]\nformat = \"%d.%m.%Y %H:%M:%S\"\n");
  EXPECT_EQ(out.dataset.time_s[1], 5);
}

constexpr const char* kGoals =
    "[[column]]\nsource = \"gx\"\nchannel = \"goal_x_mm\"\n"
    "[[column]]\nsource = \"gy\"\nchannel = \"goal_y_mm\"\n"
    "[group]\nchannels = [\"goal_x_mm\", \"goal_y_mm\"]\nwithin = 0.1\n";

TEST(ImportDataset, KeepsTheVisitsOfOneGoalTogether) {
  const auto out = imported("gx,gy\n1,1\n2,1\n1.05,0.95\n2,1.3\n,1\n,1\n", kGoals);
  EXPECT_EQ(out.dataset.line, (std::vector<std::int64_t>{1, 2, 1, 3, 4, 4}));
  EXPECT_EQ(out.report.groups, 4U);
  EXPECT_EQ(out.report.largest_group, 2U);
  EXPECT_EQ(out.report.median_group, 1.5);
}

TEST(ImportDataset, GivesWholeGoalsToTheValidationSet) {
  std::string text = "gx,gy\n";
  std::mt19937 random(619);
  for (int i = 0; i < 4000; ++i)
    text += std::to_string(random() % 40) + "," + std::to_string(random() % 10) + "\n";
  for (const char* rule : {"validation_every = 5\n", "validation_share = 0.2\nseed = 3\n"}) {
    const auto out = imported(text, std::string(kGoals) + "[sets]\n" + rule);
    std::map<std::int64_t, std::set<PointSet>> sets;
    std::set<std::int64_t> validation;
    for (std::size_t row = 0; row < out.dataset.rows; ++row) {
      sets[out.dataset.line[row]].insert(out.dataset.set[row]);
      if (out.dataset.set[row] == PointSet::validation) validation.insert(out.dataset.line[row]);
    }
    for (const auto& [goal, found] : sets) EXPECT_EQ(found.size(), 1U) << goal;
    // 400 goals: 80 by count; by hash within four standard deviations (8) of 80.
    EXPECT_NEAR(static_cast<double>(validation.size()), 80, 32) << rule;
    EXPECT_EQ(out.report.validation + out.report.calibration, 4000U);
  }
}

TEST(ImportDataset, ReadsTheSetFromAColumn) {
  const auto out = imported("x,split\n1,train\n2,test\n3,val\n",
                            "[[column]]\nsource = \"x\"\nchannel = \"x_mm\"\n[sets]\n"
                            "column = \"split\"\nvalidation = [\"test\", \"val\"]\n");
  EXPECT_EQ(out.dataset.set, (std::vector<PointSet>{PointSet::calibration, PointSet::validation,
                                                    PointSet::validation}));
}

// The flange hangs 100 mm behind the target along its z; the tracker's x is the robot's y.
TEST(ImportDataset, TakesAPoseToTheWantedBodyAndFrame) {
  const auto out = imported(
      "x,y,z,a,b,c\n1000,0,0,0,90,0\n1000,,0,0,90,0\n",
      "[[column]]\nsource = \"x\"\nchannel = \"x_mm\"\n"
      "[[column]]\nsource = \"y\"\nchannel = \"y_mm\"\n"
      "[[column]]\nsource = \"z\"\nchannel = \"z_mm\"\n"
      "[[column]]\nsource = \"a\"\nunit = \"deg\"\nchannel = \"rx_deg\"\n"
      "[[column]]\nsource = \"b\"\nunit = \"deg\"\nchannel = \"ry_deg\"\n"
      "[[column]]\nsource = \"c\"\nunit = \"deg\"\nchannel = \"rz_deg\"\n"
      "[[pose]]\nposition = [\"x_mm\", \"y_mm\", \"z_mm\"]\n"
      "rotation = [\"rx_deg\", \"ry_deg\", \"rz_deg\"]\nconvention = \"xyz-fixed\"\n"
      "into_position = [\"flange_x_m\", \"flange_y_m\", \"flange_z_m\"]\n"
      "into_rotation = [\"flange_rx_arcsec\", \"flange_ry_arcsec\", \"flange_rz_arcsec\"]\n"
      "[pose.tool]\ntranslation_mm = [0, 0, -100]\n[pose.frame]\nrotation_deg = [0, 0, 90]\n");
  const auto value = [&](const char* symbol, std::size_t row) {
    return out.dataset.find(symbol)->values[row];
  };
  // The target's z points along the tracker's x: the flange is at x = 900 there, y = 0.9 m here.
  EXPECT_NEAR(value("flange_x", 0), 0, 1e-12);
  EXPECT_NEAR(value("flange_y", 0), 0.9, 1e-12);
  EXPECT_NEAR(value("flange_ry", 0), 90 * 3600, 1e-6);
  EXPECT_EQ(value("x", 0), 1000) << "what was measured stays";
  EXPECT_TRUE(is_missing(value("flange_x", 1)) && is_missing(value("flange_rz", 1)));
}

struct ImportMistake {
  const char* name;
  const char* text;
  const char* reason;
  const char* says;
};
class BadForeignFile : public testing::TestWithParam<ImportMistake> {};
TEST_P(BadForeignFile, IsRefusedWithFileLineFieldFoundAndExpected) {
  const auto error = refused(GetParam().text, kTwoColumns);
  EXPECT_EQ(error.code, ErrorCode::invalid_argument);
  EXPECT_EQ(error.reason, GetParam().reason);
  EXPECT_THAT(error.message, HasSubstr(GetParam().says));
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadForeignFile,
    testing::Values(
        ImportMistake{"Empty", "", "NO_HEADER", "lab.csv:0: found no row"},
        ImportMistake{"OnlyHeader", "pos;temp\n", "NO_ROWS", "lab.csv:1: found a header row"},
        ImportMistake{"OtherSeparator", "pos,temp\n1,2\n", "UNKNOWN_COLUMN",
                      "is the mapping's separator the file's?"},
        ImportMistake{"Misspelt", "Pos;temp\n1;2\n", "UNKNOWN_COLUMN",
                      "column 1 of the mapping: found no column named 'pos': did you mean 'Pos'?"},
        ImportMistake{"Twins", "pos;temp;pos\n1;2;3\n", "AMBIGUOUS_COLUMN",
                      "found 2 columns named 'pos'"},
        ImportMistake{"Ragged", "pos;temp\n1;2\n1;2;3\n", "RAGGED_ROW",
                      "lab.csv:3: found 3 fields, expected 2 as in line 1"},
        ImportMistake{"OtherDecimal", "pos;temp\n1;2\n1.5;2\n", "BAD_NUMBER",
                      "lab.csv:3: column 'pos': found '1.5', expected a finite number (the mapping "
                      "says decimal = \",\")"},
        ImportMistake{"Word", "pos;temp\n1;warm\n", "BAD_NUMBER", "column 'temp': found 'warm'"},
        ImportMistake{"Overflow", "pos;temp\n1e306;2\n", "BAD_NUMBER", "found '1e306'"}),
    [](const auto& row) { return std::string(row.param.name); });

// What was imported is a dataset like any other: it writes and reads back to the last digit.
TEST(ImportDataset, GivesADatasetThatReadsBack) {
  std::mt19937_64 random(230);
  std::uniform_real_distribution<double> metres(-2, 2);
  std::string text = "pos;temp\n";
  std::vector<double> expected_mm;
  for (int i = 0; i < 1000; ++i) {
    const double m = metres(random);
    std::string field = number_text(m);
    for (char& c : field)
      if (c == '.') c = ',';
    text += field + ";293,15\n";
    // The decimal text with its point moved, read by the C library.
    expected_mm.push_back(std::stod(number_text(m) + "e3"));
    if (number_text(m).find('e') != std::string::npos) expected_mm.back() = m * 1000;
  }
  const auto out = imported(text, kTwoColumns);
  EXPECT_EQ(out.dataset.find("x")->values, expected_mm);
  const auto again = read_dataset_csv(write_dataset_csv(out.dataset), "again.csv");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->find("x")->values, expected_mm);
}

TEST(ImportDataset, GivesAnErrorWithItsPlaceForAnyDamage) {
  const std::string good = "pos;temp\n0,5;293,15\n1,5;294,15\n\"2\";\"293\"\n";
  const auto mapping = mapping_of(kTwoColumns);
  std::mt19937 random(1);
  int refusals = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string text = good;
    for (auto n = 1 + random() % 4; n > 0; --n)
      text[random() % text.size()] = static_cast<char>(random());
    const auto out = import_dataset(text, "lab.csv", mapping);
    if (out) continue;
    ++refusals;
    EXPECT_THAT(out.error().message, testing::StartsWith("lab.csv:"));
  }
  EXPECT_GT(refusals, 1000);
}

}  // namespace
}  // namespace driftwise::formats
