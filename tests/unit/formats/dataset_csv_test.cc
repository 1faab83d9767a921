#include "server/formats/csv/dataset_csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <random>

namespace driftwise::formats {
namespace {

constexpr const char* kFile = "drift.csv";

TEST(ReadDatasetCsv, ReadsTheTableOfTheDesign) {
  const auto data = read_dataset_csv(
      "# driftwise-dataset: 1\n# cell: micro-nano\n"
      "time_s,set,line,zero,dwell_s,q1_mm,x_mm,t04_degC,pressure_hPa\n"
      "12.53,calibration,0,1,9.1,0,0.000131442,20.5,\n"
      "40,validation,1,0,,-4.0000001,-4,20.6,1013.25\n",
      kFile);
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_EQ(data->rows, 2u);
  EXPECT_EQ(data->metadata[1], (std::pair<std::string, std::string>{"cell", "micro-nano"}));
  EXPECT_EQ(data->time_s, (std::vector<double>{12.53, 40}));
  EXPECT_EQ(data->set_of(1), PointSet::validation);
  EXPECT_EQ(data->line[1], 1);
  EXPECT_EQ(data->zero[0], 1);
  EXPECT_TRUE(is_missing(data->dwell_s[1]));
  ASSERT_EQ(data->columns.size(), 4u);
  EXPECT_EQ(data->find("x")->values[0], 0.000131442);
  EXPECT_TRUE(is_missing(data->find("pressure")->values[0]));
  EXPECT_EQ(data->find("pressure")->channel.unit, "hPa");
}

TEST(ReadDatasetCsv, TakesRowsWithoutTimeAndSetAsUntimedCalibration) {
  const auto data = read_dataset_csv("q1_mm,x_mm\n1,2\n3,4", kFile);
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_TRUE(data->time_s.empty());
  EXPECT_EQ(data->set_of(1), PointSet::calibration);
  EXPECT_EQ(data->find("x")->values, (std::vector<double>{2, 4}));
}

TEST(ReadDatasetCsv, AcceptsByteOrderMarkCarriageReturnsBlanksAndEmptyLines) {
  const auto data =
      read_dataset_csv("\xEF\xBB\xBF# a: b\r\n\r\ntime_s , x_mm\r\n 1 ,\t2 \r\n\r\n2,3\r\n", kFile);
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_EQ(data->rows, 2u);
  EXPECT_EQ(data->columns[0].values, (std::vector<double>{2, 3}));
}

struct DatasetMistake {
  const char* name;
  const char* text;
  const char* reason;
  const char* says;
};
class BadDataset : public testing::TestWithParam<DatasetMistake> {};
TEST_P(BadDataset, IsRefusedWithFileLineFieldFoundAndExpected) {
  const auto data = read_dataset_csv(GetParam().text, kFile);
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(data.error().reason, GetParam().reason);
  EXPECT_TRUE(data.error().message.find(GetParam().says) != std::string::npos)
      << data.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadDataset,
    testing::Values(
        DatasetMistake{"Empty", "", "EMPTY_FILE", "drift.csv:1: the file is empty"},
        DatasetMistake{"OnlyMetadata", "# a: b\n", "NO_HEADER", "drift.csv:1: found no header row"},
        DatasetMistake{"NoRows", "# a: b\nx_mm\n", "NO_ROWS",
                       "drift.csv:2: found a header row and nothing after it"},
        DatasetMistake{"NoUnit", "time_s,x\n1,2\n", "BAD_CHANNEL",
                       "drift.csv:1: column 2: 'x' is no channel"},
        DatasetMistake{"UnknownUnit", "x_furlong\n1\n", "BAD_CHANNEL", "column 1: 'x_furlong'"},
        DatasetMistake{
            "Twins", "x_mm,q1_mm,x_mm\n1,2,3\n", "DUPLICATE_COLUMN",
            "columns 1 and 3 are both named 'x_mm': rename one of them, or leave it out"},
        DatasetMistake{"NoName", "x_mm,,q1_mm\n1,2,3\n", "NO_HEADER",
                       "column 2 has no name: name it, or leave the column out"},
        DatasetMistake{"TrailingComma", "x_mm,\n1,\n", "NO_HEADER",
                       "column 2 has no name: leave out the comma at the end of the line, here and "
                       "in the rows"},
        DatasetMistake{"TrailingCommaOfARow", "x_mm\n1,\n", "RAGGED_ROW",
                       "found 2 fields, expected 1 as in the header row: leave out the comma at "
                       "the end of the line"},
        DatasetMistake{"NoHeaderRow", "# a: b\n0.000,12.5\n1,2\n", "NO_HEADER",
                       "drift.csv:2: found the number '0.000' where column 1 has its name: the "
                       "file needs a header row such as time_s,q1_mm,x_mm"},
        DatasetMistake{"TimeInHours", "time_h,x_mm\n1,2\n", "BAD_CHANNEL",
                       "the time of a row goes in time_s, in seconds; another program's table: "
                       "driftwise data import"},
        DatasetMistake{
            "TimeOfDay", "time_s,x_mm\n2026-11-28T10:00:00,0\n", "BAD_NUMBER",
            "time_s is in seconds from any start; dates and times of day: driftwise data import"},
        DatasetMistake{"Semicolons", "x_mm;q1_mm\n1;2\n", "NO_HEADER", "separated by commas"},
        DatasetMistake{"SemicolonsOfAnotherProgram", "Time;Position\n1;2,5\n", "NO_HEADER",
                       "driftwise data import FILE --mapping MAP.toml"},
        DatasetMistake{"NamesOfAnotherProgram", "Time,X [mm]\n1,2\n", "BAD_CHANNEL",
                       "driftwise data import FILE --mapping MAP.toml"},
        DatasetMistake{"TimeRunsBack", "time_s,x_mm\n2,0\n1,0\n", "TIME_NOT_INCREASING",
                       "drift.csv:3: column time_s: found 1 after 2"},
        DatasetMistake{"TimeStands", "time_s,x_mm\n2,0\n2,0\n", "TIME_NOT_INCREASING",
                       "found 2 after 2"},
        DatasetMistake{
            "RowsOutOfOrder", "time_s,x_mm\n0,0\n20.5,0\n10,0\n", "TIME_NOT_INCREASING",
            "drift.csv:4: column time_s: found 10 after 20.5, expected a later time in every row: "
            "where a second run begins here and its clock restarts, add 11 s, and the pause "
            "between the runs, to the times from this line on, and number the runs in a column "
            "run; where single rows are out of order, sort them"},
        DatasetMistake{"JoinedRuns", "time_s,run,x_mm\n5,1,0\n1980,1,0\n0,2,0\n",
                       "TIME_NOT_INCREASING",
                       "drift.csv:4: column time_s: found 0 after 1980, expected a later time in "
                       "every row: the clock restarts with run 2: add 1980 s, and the pause "
                       "between the runs, to the times from this line on"},
        DatasetMistake{"RowTwice", "time_s,x_mm\n2,0\n2,0\n", "TIME_NOT_INCREASING",
                       "leave out a row that is there twice"},
        DatasetMistake{"TimeMissing", "time_s,x_mm\n,0\n", "BAD_NUMBER",
                       "drift.csv:2: column time_s: found nothing, expected seconds"},
        DatasetMistake{
            "OtherSet", "set,x_mm\n2nd,0\n", "BAD_SET",
            "drift.csv:2: column set: found '2nd', expected calibration, validation, or the name"},
        DatasetMistake{"LongSet", "set,x_mm\ncalibrations,0\n", "BAD_SET", "found 'calibrations'"},
        DatasetMistake{"ShortRow", "x_mm,q1_mm\n1,2\n3\n", "RAGGED_ROW",
                       "drift.csv:3: found 1 field, expected 2"},
        DatasetMistake{"LongRow", "x_mm,q1_mm\n1,2,3\n", "RAGGED_ROW",
                       "drift.csv:2: found 3 fields, expected 2"},
        DatasetMistake{"Word", "x_mm,q1_mm\n1,abc\n", "BAD_NUMBER",
                       "drift.csv:2: column q1_mm: found 'abc', expected a finite number"},
        DatasetMistake{"ColumnOfText", "x_mm,note_1\n1,ok\n", "BAD_NUMBER",
                       "or nothing: leave a column of text out"},
        DatasetMistake{"Tail", "x_mm\n1.5mm\n", "BAD_NUMBER", "found '1.5mm'"},
        DatasetMistake{"DecimalComma", "x_mm\n1,5\n", "RAGGED_ROW",
                       "found 2 fields, expected 1 as in the header row: twice as many, as of "
                       "decimal commas: write decimals with points"},
        DatasetMistake{"Nan", "x_mm\nnan\n", "BAD_NUMBER", "found 'nan'"},
        DatasetMistake{"MinusInf", "x_mm\n-inf\n", "BAD_NUMBER", "found '-inf'"},
        DatasetMistake{"TwoSigns", "x_mm\n+-1\n", "BAD_NUMBER", "found '+-1'"},
        DatasetMistake{"PlusWord", "x_mm\n+inf\n", "BAD_NUMBER", "found '+inf'"},
        DatasetMistake{"TooLarge", "x_mm\n1e999\n", "BAD_NUMBER", "found '1e999'"},
        DatasetMistake{"Quotes", "x_mm\n\"1\"\n", "QUOTED_FIELD",
                       "drift.csv:2: column x_mm: found '\"1\"'"},
        DatasetMistake{"QuotedHeader", "\"x_mm\"\n1\n", "QUOTED_FIELD", "drift.csv:1"},
        DatasetMistake{"ExcludedFlag", "excluded,x_mm\nyes,1\n", "BAD_FLAG",
                       "column excluded: found 'yes', expected 0 or 1"},
        DatasetMistake{"ZeroFlag", "zero,x_mm\n2,1\n", "BAD_FLAG",
                       "column zero: found '2', expected 0 or 1"},
        DatasetMistake{"Line", "line,x_mm\n1.5,1\n", "BAD_INTEGER",
                       "column line: found '1.5', expected a whole number"},
        DatasetMistake{"NoLine", "line,x_mm\n,1\n", "BAD_INTEGER", "column line: found nothing"},
        DatasetMistake{"Version", "# driftwise-dataset: 2\nx_mm\n1\n", "UNSUPPORTED_VERSION",
                       "found driftwise-dataset '2', expected version 1"},
        DatasetMistake{"OldMacintosh", "x_mm\r1\r2\r", "NOT_TEXT", "carriage return alone"},
        DatasetMistake{"Utf16", "\xFF\xFEx", "NOT_TEXT", "UTF-16"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(ReadDatasetCsv, ShowsUnprintableBytesByTheirCodes) {
  const auto data = read_dataset_csv("x_mm\n\x01\n", kFile);
  ASSERT_FALSE(data);
  EXPECT_TRUE(data.error().message.find("'\\x01'") != std::string::npos) << data.error().message;
}

std::uint64_t bits(double value) {
  std::uint64_t out;
  std::memcpy(&out, &value, sizeof out);
  return out;
}

// The property the format promises, over doubles of every size: not a tolerance, the same bits.
TEST(DatasetCsv, ReadsBackEveryNumberBitForBit) {
  std::mt19937_64 random(20110722);
  Dataset data;
  data.rows = 2000;
  data.columns = {{{"x", "mm"}, {}}, {{"t07", "degC"}, {}}};
  for (std::size_t i = 0; i < data.rows; ++i) {
    double wild;
    const std::uint64_t raw = random();
    std::memcpy(&wild, &raw, sizeof wild);
    data.columns[0].values.push_back(std::isfinite(wild) ? wild : -0.0);
    data.columns[1].values.push_back(
        i % 7 ? 20.0 + 1e-9 * static_cast<double>(random() % 1000000000) : kMissing);
    data.time_s.push_back(static_cast<double>(i) / 3.0);
    data.set.push_back(i % 3 ? PointSet::calibration : PointSet::validation);
    data.line.push_back(static_cast<std::int64_t>(i / 19));
    data.zero.push_back(i % 19 == 0);
    data.excluded.push_back(i % 23 == 0);
    data.dwell_s.push_back(i % 5 ? 2.5 : kMissing);
    data.run.push_back(3);
    data.datum.push_back(static_cast<std::int64_t>(i / 900));
  }
  data.columns[0].values[0] = std::numeric_limits<double>::denorm_min();
  data.columns[0].values[1] = std::numeric_limits<double>::max();
  data.metadata = {{"cell", "linear-axis"},
                   {"", "a remark without a key"},
                   {"seen", "10:30:00 by ada"},
                   {"", ":: no key: here"}};

  const std::string text = write_dataset_csv(data);
  const auto back = read_dataset_csv(text, kFile);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->rows, data.rows);
  EXPECT_EQ(back->time_s, data.time_s);
  EXPECT_EQ(back->set, data.set);
  EXPECT_EQ(back->line, data.line);
  EXPECT_EQ(back->zero, data.zero);
  EXPECT_EQ(back->excluded, data.excluded);
  EXPECT_EQ(back->run, data.run);
  EXPECT_EQ(back->datum, data.datum);
  for (std::size_t c = 0; c < data.columns.size(); ++c)
    for (std::size_t i = 0; i < data.rows; ++i) {
      const double was = data.columns[c].values[i], is = back->columns[c].values[i];
      ASSERT_TRUE(is_missing(was) ? is_missing(is) : bits(was) == bits(is)) << "row " << i;
    }
  EXPECT_EQ(write_dataset_csv(*back), text);  // and so the text is reproduced too, remarks included
}

// Several megabytes, read in chunks: the lines here are of one width, so that the first row of a
// chunk is known.
struct LongFile {
  static constexpr std::size_t kRows = 100000;
  std::string text = "time_s,q1_mm,x_mm\n";
  std::size_t width = 0;

  LongFile() {
    for (std::size_t i = 0; i < kRows; ++i) {
      char line[64];
      const int size = std::snprintf(line, sizeof line, "%08zu.0,%14.9f,%14.6e\n", i,
                                     1e-3 * double(i), std::sin(double(i)));
      width = static_cast<std::size_t>(size);
      text += line;
    }
  }
  std::size_t place(std::size_t row) const { return text.find('\n') + 1 + row * width; }
  // The first rows of the chunks after the first, whatever their exact size near a megabyte is:
  // those around each multiple of it.
  std::vector<std::size_t> rows_to_break() const {
    std::vector<std::size_t> rows = {1, kRows - 1};
    for (std::size_t megabyte = 1; megabyte * 1048576 < text.size(); ++megabyte) {
      const std::size_t row = megabyte * 1048576 / width;
      for (std::size_t near = row - 2; near <= row + 4 && near < kRows; ++near)
        rows.push_back(near);
    }
    return rows;
  }
};

calibration::Executor backwards() {  // the order that finds most mistakes
  return [](std::size_t count, const std::function<void(std::size_t)>& job) {
    while (count > 0) job(--count);
  };
}

TEST(ReadDatasetCsv, ReadsALongFileInChunksAsInOnePiece) {
  LongFile file;
  file.text.insert(file.place(70000), "\n\r\n\n");  // empty lines: rows close up
  file.text.insert(file.place(10), "\n");
  const auto data = read_dataset_csv(file.text, kFile, backwards());
  ASSERT_TRUE(data) << data.error().message;
  ASSERT_EQ(data->rows, LongFile::kRows);
  for (std::size_t i = 0; i < data->rows; ++i) {
    ASSERT_EQ(data->time_s[i], static_cast<double>(i));
    ASSERT_NEAR(data->columns[0].values[i], 1e-3 * static_cast<double>(i), 1e-9);
    ASSERT_NEAR(data->columns[1].values[i], std::sin(static_cast<double>(i)), 1e-6);
  }
  EXPECT_EQ(data->columns[1].values.size(), LongFile::kRows);
}

TEST(ReadDatasetCsv, NamesTheLineOfAMistakeInAnyChunk) {
  const LongFile good;
  for (const std::size_t row : good.rows_to_break()) {
    LongFile file = good;
    file.text[file.place(row)] = '-';                       // the time runs back
    file.text[file.place(LongFile::kRows - 1) + 12] = 'x';  // a later mistake, too
    const auto data = read_dataset_csv(file.text, kFile, backwards());
    ASSERT_FALSE(data);
    const bool is_last = row == LongFile::kRows - 1;
    EXPECT_EQ(data.error().reason, is_last ? "BAD_NUMBER" : "TIME_NOT_INCREASING");
    EXPECT_EQ(data.error().message.find("drift.csv:" + std::to_string(row + 2) + ": "), 0u)
        << data.error().message;
  }
}

// A row needs a byte for every field: text of empty lines must not make room for rows.
TEST(ReadDatasetCsv, TakesNoMemoryForEmptyLines) {
  std::string text = "a0_mm";
  for (int i = 1; i < 4000; ++i) text += ",a" + std::to_string(i) + "_mm";
  text += "\n" + std::string(2000000, '\n');  // 4000 x 2e6 numbers would be 64 GB
  const auto data = read_dataset_csv(text, kFile);
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().reason, "NO_ROWS");
}

TEST(DatasetCsv, KeepsAMissingValueInAFileOfOneColumn) {
  Dataset data;
  data.rows = 3;
  data.columns = {{{"x", "mm"}, {1.0, kMissing, 3.0}}};
  const auto back = read_dataset_csv(write_dataset_csv(data), kFile);
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_EQ(back->rows, 3u);
  EXPECT_TRUE(is_missing(back->columns[0].values[1]));
}

// As the mapping of an import and the text line take it; the nearest double of 1e-400 is zero.
TEST(DatasetCsv, TakesAPlusAndANumberTooSmallForADouble) {
  const auto data = read_dataset_csv("x_mm,q1_mm\n+20.03,1e-400\n+1e3,-1e-400\n", "a.csv");
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_EQ(data->find("x")->values, (std::vector<double>{20.03, 1000}));
  EXPECT_EQ(data->find("q1")->values, (std::vector<double>{0, 0}));
}

}  // namespace
}  // namespace driftwise::formats
