// export(import(file)) == file, to the byte, for a file that our exporter wrote.

#include "server/core/data/row_marks.h"
#include "server/formats/csv/dataset_csv.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using CsvRoundTrip = StoreTest;

std::string exported_after_import(Store& store, const std::string& csv) {
  const Dataset file = formats::read_dataset_csv(csv, "given.csv").value();
  const RunId run = store.runs().import_dataset(example_run("imported"), file).value().id;
  return formats::write_dataset_csv(store.runs().dataset(std::vector{run}).value());
}

TEST_F(CsvRoundTrip, KeepsAnExportOfOneRun) {
  for (int row = 0; row < 40; ++row)
    ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
  Dataset dataset = store->runs().dataset(std::vector{run}).value();
  dataset.metadata = {{"cell", "linear-axis"}, {"exported", "2026-11-21T08:00:00Z"}};
  const std::string csv = formats::write_dataset_csv(dataset);
  EXPECT_EQ(exported_after_import(*store, csv), csv);
}

TEST_F(CsvRoundTrip, KeepsAnExportOfTwoRunsAndThreeDatums) {
  const RunId later = store->runs().create_run(example_run("later")).value().id;
  const DatumId second = store->points().open_datum(example_datum(run, 50)).value();
  const DatumId third = store->points().open_datum(example_datum(later, 500)).value();
  for (int row = 0; row < 3; ++row) {
    ASSERT_TRUE(store->points().commit(example_commit(run, row == 0 ? datum : second, row)));
    PointCommit commit = example_commit(later, third, 40 + row);
    commit.point->values.push_back({"air_degC", row == 1 ? kMissing : 20.0 + 0.1 * row});
    ASSERT_TRUE(store->points().commit(commit));
  }
  const std::string csv =
      formats::write_dataset_csv(store->runs().dataset(std::vector{run, later}).value());
  EXPECT_EQ(exported_after_import(*store, csv), csv);
}

TEST_F(CsvRoundTrip, KeepsAWrittenFileWithOddColumnsAndGaps) {
  const std::string given =
      "# driftwise-dataset: 1\n# note: twice, with commas\n# note: \n"
      "time_s,zero,dwell_s,strain_7_1,x_mm,q1_mm,t07_degC\n"
      "-5.5,1,,-0,0.000131442,0,20.000000000000004\n12.53,0,9.1,1e-300,,1,\n";
  const std::string csv =
      formats::write_dataset_csv(formats::read_dataset_csv(given, "odd.csv").value());
  EXPECT_EQ(exported_after_import(*store, csv), csv);
}

TEST_F(CsvRoundTrip, KeepsWhichRowsAreExcluded) {
  for (int row = 0; row < 5; ++row)
    ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
  ExclusionRecord out{.id = 0,
                      .run = run,
                      .excluded = true,
                      .rows = {1, 4},
                      .reason = "fan",
                      .at = at_s(99),
                      .who = "ada",
                      .from = ""};
  ASSERT_TRUE(store->remarks().exclude(out));
  const std::string csv =
      formats::write_dataset_csv(store->runs().dataset(std::vector{run}).value());
  EXPECT_THAT(csv, testing::HasSubstr("dwell_s,excluded,q1_mm"));
  EXPECT_EQ(exported_after_import(*store, csv), csv);
}

TEST_F(CsvRoundTrip, KeepsWhichRowsAreBesideThePlan) {
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 1)));
  PointCommit second = example_commit(run, datum, 2);
  PointRecord passage = *second.point;
  passage.zero = true;
  passage.measured = at_s(30);
  passage.values = {{"q1_mm", 1e-5}, {"t01_degC", 20.52}};
  second.passages = {passage};
  ASSERT_TRUE(store->points().commit(second));
  const std::string csv =
      formats::write_dataset_csv(store->runs().dataset(std::vector{run}).value());
  EXPECT_THAT(csv, testing::HasSubstr("dwell_s,excluded,passage,q1_mm"));
  const Dataset read = formats::read_dataset_csv(csv, "run.csv").value();
  EXPECT_THAT(read.excluded, testing::ElementsAre(kInUse, kPassageRow, kInUse));
  EXPECT_EQ(exported_after_import(*store, csv), csv);
}

TEST_F(CsvRoundTrip, WithoutSuchARowAFileHasNoSuchColumn) {
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 1)));
  const auto rows = store->runs().dataset(std::vector{run}).value();
  EXPECT_THAT(rows.excluded, testing::IsEmpty());
  EXPECT_THAT(formats::write_dataset_csv(rows), testing::Not(testing::HasSubstr("passage")));
}

// All of it through the migrations: the rows are those that version 1 exported itself.
TEST(CsvOfVersion1, IsWhatVersion1Exported) {
  const TemporaryFolder folder;
  const auto store = open_store(copy_of_version_1_cell(folder));
  std::ifstream file(DRIFTWISE_SOURCE_DIR "/tests/data/databases/version_1_cell_run_1.csv");
  std::stringstream exported;
  exported << file.rdbuf();
  for (const std::int64_t run : {1, 2}) {  // 2: the import of that file
    Dataset dataset = store->runs().dataset(std::vector{RunId{run}}).value();
    dataset.metadata = formats::read_dataset_csv(exported.str(), "v1.csv")->metadata;
    EXPECT_EQ(formats::write_dataset_csv(dataset), exported.str());
  }
}

}  // namespace
}  // namespace driftwise::storage
