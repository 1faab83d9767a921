#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using DatasetTest = StoreTest;

std::vector<std::string> names(const Dataset& dataset) {
  std::vector<std::string> all;
  for (const auto& column : dataset.columns) all.push_back(column.channel.name());
  return all;
}

bool same_bits(double a, double b) {
  return (is_missing(a) && is_missing(b)) || (a == b && std::signbit(a) == std::signbit(b));
}

void expect_same(const Dataset& a, const Dataset& b) {
  EXPECT_EQ(a.metadata, b.metadata);
  EXPECT_EQ(a.rows, b.rows);
  EXPECT_EQ(a.time_s, b.time_s);
  EXPECT_EQ(a.set, b.set);
  EXPECT_EQ(a.line, b.line);
  EXPECT_EQ(a.zero, b.zero);
  ASSERT_EQ(a.dwell_s.size(), b.dwell_s.size());
  for (std::size_t i = 0; i < a.dwell_s.size(); ++i)
    EXPECT_TRUE(same_bits(a.dwell_s[i], b.dwell_s[i]));
  EXPECT_EQ(a.run, b.run);
  EXPECT_EQ(a.datum, b.datum);
  ASSERT_EQ(names(a), names(b));
  for (std::size_t c = 0; c < a.columns.size(); ++c)
    for (std::size_t i = 0; i < a.rows; ++i)
      EXPECT_TRUE(same_bits(a.columns[c].values[i], b.columns[c].values[i]))
          << a.columns[c].channel.name() << " row " << i;
}

NewRun import_run() {
  NewRun run = example_run("imported");
  run.trajectory_text = run.trajectory_name = "";
  return run;
}

TEST_F(DatasetTest, HasOneRowPerPointWithTimeFromTheFirst) {
  for (int row = 0; row < 4; ++row)
    ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
  const Dataset dataset = store->runs().dataset(std::vector{run}).value();
  EXPECT_EQ(dataset.rows, 4u);
  EXPECT_THAT(dataset.time_s, testing::ElementsAre(0.0, 14.0, 28.0, 42.0));
  EXPECT_THAT(dataset.set, testing::ElementsAre(PointSet::calibration, PointSet::validation,
                                                PointSet::calibration, PointSet::validation));
  EXPECT_THAT(dataset.zero, testing::ElementsAre(1, 0, 0, 0));
  EXPECT_THAT(dataset.dwell_s, testing::Each(2.2));
  EXPECT_TRUE(dataset.run.empty());
  EXPECT_TRUE(dataset.datum.empty());
  EXPECT_TRUE(dataset.metadata.empty());
  EXPECT_THAT(names(dataset),
              testing::ElementsAre("q1_mm", "q1_cmd_mm", "x_mm", "x_std_nm", "t01_degC", "t02_degC",
                                   "t03_degC", "t04_degC", "t05_degC", "t06_degC", "t07_degC",
                                   "t08_degC", "t09_degC"));
  EXPECT_THAT(dataset.find("q1_cmd")->values, testing::ElementsAre(0.0, 1.0, 2.0, 3.0));
  EXPECT_EQ(dataset.find("q1")->values[2], 2.0 + 2.5e-5);
}

TEST_F(DatasetTest, LeavesMissingWhatAPointDidNotMeasure) {
  PointCommit with_more = example_commit(run, datum, 0);
  with_more.point->values.push_back({"air_degC", 20.7});
  PointCommit missing = example_commit(run, datum, 1);
  missing.point->values.back().value = kMissing;
  ASSERT_TRUE(store->points().commit(with_more));
  ASSERT_TRUE(store->points().commit(missing));
  const Dataset dataset = store->runs().dataset(std::vector{run}).value();
  EXPECT_EQ(names(dataset).back(), "air_degC");
  EXPECT_EQ(dataset.find("air")->values[0], 20.7);
  EXPECT_TRUE(is_missing(dataset.find("air")->values[1]));
  EXPECT_TRUE(is_missing(dataset.find("t09")->values[1]));
}

TEST_F(DatasetTest, NamesTheDatumWhereThereIsMoreThanOne) {
  const DatumId second = store->points().open_datum(example_datum(run, 20)).value();
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 0)));
  ASSERT_TRUE(store->points().commit(example_commit(run, second, 1)));
  const Dataset dataset = store->runs().dataset(std::vector{run}).value();
  EXPECT_THAT(dataset.datum, testing::ElementsAre(datum.value, second.value));
  EXPECT_TRUE(dataset.run.empty());
}

TEST_F(DatasetTest, JoinsRunsInTimeWhateverTheirOrder) {
  const RunId later = store->runs().create_run(example_run("later")).value().id;
  const DatumId later_datum = store->points().open_datum(example_datum(later, 500)).value();
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 0)));
  ASSERT_TRUE(store->points().commit(example_commit(later, later_datum, 40)));
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 1)));
  const Dataset dataset = store->runs().dataset(std::vector{later, run}).value();
  EXPECT_THAT(dataset.time_s, testing::ElementsAre(0.0, 14.0, 560.0));
  EXPECT_THAT(dataset.run, testing::ElementsAre(run.value, run.value, later.value));
  EXPECT_THAT(dataset.datum, testing::ElementsAre(datum.value, datum.value, later_datum.value));
}

// 12.53 s must come back as 12.53, not 12.530000000000001: nanoseconds are divided by 1e9, which
// rounds correctly.
TEST_F(DatasetTest, GivesTimesThatReadAsTheNearestDecimal) {
  for (int row = 0; row < 2; ++row) {
    PointCommit commit = example_commit(run, datum, row);
    commit.point->measured.utc = {kStartNs + row * 12'530'000'001};
    ASSERT_TRUE(store->points().commit(commit));
  }
  EXPECT_EQ(store->runs().dataset(std::vector{run})->time_s[1], 12.530000001);
}

TEST_F(DatasetTest, RefusesNoRunAnUnknownRunAndARunNamedTwice) {
  EXPECT_EQ(store->runs().dataset({}).error().reason, "BAD_RUNS");
  EXPECT_EQ(store->runs().dataset(std::vector{run, run}).error().reason, "BAD_RUNS");
  EXPECT_EQ(store->runs().dataset(std::vector{RunId{99}}).error().reason, "NO_SUCH_RUN");
}

TEST_F(DatasetTest, GivesAnImportedFileBackExactly) {
  Dataset file;
  file.metadata = {{"driftwise-dataset", "1"},
                   {"cell", "micro-nano"},
                   {"note", "it's \"quoted\", twice"},
                   {"cell", ""}};
  file.rows = 4;
  file.time_s = {12.53, 12.530000000000001, 1e5 / 3, 4e5};
  file.set = {PointSet::validation, PointSet::calibration, PointSet::calibration,
              PointSet::validation};
  file.line = {0, 0, -3, 1LL << 60};
  file.zero = {1, 0, 0, 1};
  file.dwell_s = {9.1, kMissing, -0.0, 0};
  file.run = {7, 7, 3, 3};
  file.datum = {1, 2, 2, 1};
  file.columns = {{{"strain_7", "1"}, {1.0, -0.0, 5e-324, 1.7976931348623157e308}},
                  {{"t07", "degC"}, {kMissing, kMissing, 0.1 + 0.2, 20}},
                  {{"x", "mm"}, {kMissing, kMissing, kMissing, kMissing}},
                  {{"q1_cmd", "mm"}, {0, 1, 2, 3}},
                  {{"q1", "mm"}, {0.000131442, 1.0 / 3, 2, 3}}};
  const RunRecord imported = store->runs().import_dataset(import_run(), file).value();
  EXPECT_EQ(imported.state, RunState::done);
  EXPECT_EQ(imported.accepted, 4);
  EXPECT_EQ(imported.rows, 4);
  reopen();
  expect_same(store->runs().dataset(std::vector{imported.id}).value(), file);
}

TEST_F(DatasetTest, AnImportedRunHasNoCellFile) {
  Dataset file;
  file.rows = 2;
  file.columns = {{{"q1", "mm"}, {0, 1}}, {{"x", "mm"}, {0, 1}}};
  const RunId imported = store->runs().import_dataset(import_run(), file).value().id;
  EXPECT_EQ(store->runs().run(imported)->config_hash, "");
  EXPECT_TRUE(store->configurations().of_run(imported)->empty());
  EXPECT_EQ(store->runs().run(run)->config_hash, "c0ffee");
  ASSERT_EQ(store->configurations().of_run(run)->size(), 1u);
  // A join of runs that the cell measured has theirs.
  NewRun join = import_run();
  join.rules_json = R"({"joined":{}})";
  const RunId joined = store->runs().import_dataset(join, file).value().id;
  EXPECT_EQ(store->runs().run(joined)->config_hash, "c0ffee");
  join.rules_json = R"({"runs_of_files":[2],"joined":{}})";
  const RunId of_files = store->runs().import_dataset(join, file).value().id;
  EXPECT_EQ(store->runs().run(of_files)->config_hash, "");
}

TEST_F(DatasetTest, AddsNoFieldThatTheImportedFileDidNotHave) {
  Dataset file;
  file.rows = 2;
  file.columns = {{{"q1", "mm"}, {0, 1}}, {{"x", "mm"}, {0, 1}}};
  const RunId imported = store->runs().import_dataset(import_run(), file).value().id;
  expect_same(store->runs().dataset(std::vector{imported}).value(), file);
  EXPECT_EQ(store->points().points(imported, 0, 0)->at(1).set, PointSet::calibration);
}

TEST_F(DatasetTest, PutsAnImportedRunBehindAMeasuredOne) {
  Dataset file;
  file.rows = 3;
  file.time_s = {100, 101, 107};
  file.columns = {{{"x", "mm"}, {5, 6, 7}}};
  const RunId imported = store->runs().import_dataset(import_run(), file).value().id;
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 0)));
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 1)));
  const Dataset dataset = store->runs().dataset(std::vector{imported, run}).value();
  EXPECT_THAT(dataset.time_s, testing::ElementsAre(0, 14, 15, 16, 22));
  EXPECT_THAT(dataset.find("x")->values, testing::ElementsAre(0 + 1.5e-6, 1 + 1.5e-6, 5, 6, 7));
  EXPECT_EQ(names(dataset).front(), "q1_mm");
}

TEST_F(DatasetTest, RefusesRunsThatGiveOneSymbolInTwoUnits) {
  const auto imported = [&](std::vector<DatasetColumn> columns) {
    Dataset file;
    file.rows = 2;
    file.columns = std::move(columns);
    return store->runs().import_dataset(import_run(), file).value().id;
  };
  const RunId um = imported({{{"q1", "um"}, {0, 1}}, {{"x", "um"}, {0, 1}}});
  const RunId mixed = imported({{{"q1", "um"}, {0, 1}}, {{"x", "mm"}, {0, 1}}});
  const RunId both = imported({{{"x", "um"}, {0, 1}}, {{"x", "V"}, {0, 1}}});
  const RunId same = imported({{{"x", "um"}, {2, 3}}, {{"x", "V"}, {2, 3}}});
  const auto refused = store->runs().dataset(std::vector{um, mixed});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(refused.error().reason, "UNITS_DISAGREE");
  EXPECT_THAT(refused.error().message,
              testing::StartsWith("run 2 gives x in um, run 3 gives x in mm: "));
  EXPECT_THAT(store->runs().dataset(std::vector{um, both}).error().message,
              testing::StartsWith("run 2 gives x in um, run 4 gives x in V: "));
  EXPECT_TRUE(store->runs().dataset(std::vector{mixed})) << "alone as in its file";
  EXPECT_TRUE(store->runs().dataset(std::vector{both, same})) << "each quantity is in all rows";
}

using Lines = std::vector<std::pair<std::string, std::string>>;

TEST_F(DatasetTest, KeepsWhatSeveralFilesStateTogether) {
  const auto imported = [&](const Lines& lines, bool with_y) {
    Dataset file;
    file.rows = 2;
    file.metadata = lines;
    file.columns = {{{"x", "mm"}, {0, 1}}, {{"t05", "degC"}, {20, 21}}};
    if (with_y) file.columns.push_back({{"y", "mm"}, {0, 1}});
    return store->runs().import_dataset(import_run(), file).value().id;
  };
  const auto of = [&](const std::vector<RunId>& runs) { return store->runs().dataset(runs); };
  const Lines first = {{"cell", "elsewhere"},
                       {"overruns", "yes"},
                       {"parts", "t05=robot"},
                       {"measured_by", "x=laser"}};
  const RunId one = imported(first, false), same = imported(first, false);
  EXPECT_EQ(of({one})->metadata, first) << "alone as it is";
  EXPECT_EQ(of({one, same})->metadata,
            (Lines{{"overruns", "yes"}, {"parts", "t05=robot"}, {"measured_by", "x=laser"}}));

  // Who says nothing of a part does not contradict; of an instrument, nobody knows which it was.
  const RunId silent = imported({{"overruns", "yes"}, {"measured_by", "y=probe"}}, true);
  EXPECT_EQ(of({silent, one})->metadata,
            (Lines{{"overruns", "yes"},
                   {"parts", "t05=robot"},
                   {"measured_by", "y=probe"},
                   {"left_out", "measured_by of x: not stated by run 4"}}));
  const RunId other = imported({{"overruns", "yes"}, {"measured_by", "x=scale"}}, false);
  EXPECT_EQ(of({one, other, same})->metadata.back(),
            (Lines::value_type{"measured_by", "x=laser*4,scale*2"}));

  const auto refused = [&](const Lines& lines) {
    const RunId later = imported(lines, false);
    const auto found = of({one, later});
    EXPECT_FALSE(found);
    return found ? Error{} : found.error();
  };
  const auto overruns = refused({{"overruns", "no"}, {"parts", "t05=robot"}});
  EXPECT_EQ(overruns.reason, "METADATA_DISAGREE");
  EXPECT_EQ(overruns.code, ErrorCode::invalid_argument);
  EXPECT_THAT(overruns.message,
              testing::StartsWith("run 2 states '# overruns: yes' and run 6 does not: "));
  const auto parts = refused({{"overruns", "yes"}, {"parts", "t05=instrument"}});
  EXPECT_EQ(parts.reason, "METADATA_DISAGREE");
  EXPECT_THAT(parts.message, testing::StartsWith("run 2 states the part t05=robot and run 7 the "
                                                 "part t05=instrument: "));
}

TEST_F(DatasetTest, ImportsNothingOfATableWithUnequalColumns) {
  Dataset file;
  file.rows = 2;
  file.columns = {{{"x", "mm"}, {0, 1}}, {{"y", "mm"}, {0}}};
  EXPECT_EQ(store->runs().import_dataset(import_run(), file).error().reason, "BAD_DATASET");
  file.columns[1] = file.columns[0];
  EXPECT_EQ(store->runs().import_dataset(import_run(), file).error().reason, "BAD_DATASET");
  EXPECT_EQ(store->runs().runs(0, 0)->size(), 1u);
}

TEST_F(DatasetTest, ImportsOneRequestOnce) {
  Dataset file;
  file.rows = 1;
  file.columns = {{{"x", "mm"}, {0}}};
  NewRun wanted = import_run();
  wanted.request_id = "import-1";
  const RunId first = store->runs().import_dataset(wanted, file).value().id;
  EXPECT_EQ(store->runs().import_dataset(wanted, file).value().id, first);
}

}  // namespace
}  // namespace driftwise::storage
