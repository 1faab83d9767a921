// The chain over the record: what is stored verifies, what was changed since is named.

#include <malloc.h>

#include <algorithm>

#include "server/core/records/audit_records.h"
#include "server/digest/sha256.h"
#include "storage/chain/value_bytes.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using testing::HasSubstr;

class ChainTest : public StoreTest {
 protected:
  void store_points(int count) {
    for (int row = 0; row < count; ++row)
      ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
  }
  // As somebody with the file and SQLite's library, without our code.
  void change(const std::string& sql) {
    store.reset();
    Database db(path, SQLITE_OPEN_READWRITE, "");
    db.execute("PRAGMA ignore_check_constraints = ON; PRAGMA foreign_keys = OFF; " + sql);
  }
  ChainReport verified(const std::optional<ChainHead>& outside = {}) {
    return open_store(path, true)->audit().verify(outside, {}).value();
  }
  std::string first_found() {
    const auto report = verified();
    return report.first.empty() ? "nothing" : report.first.front();
  }
};

// FIPS 180-4's examples: NIST's "abc" and the empty text.
TEST(Digest, IsSha256) {
  EXPECT_EQ(digest::sha256_hex("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(digest::sha256_hex(""),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(ValueBytes, WriteAnIntegerInAsFewBytesAsHoldIt) {
  const auto bytes = [](std::int64_t value) {
    std::string out;
    add_integer(out, value);
    return digest::hex_from(out);
  };
  EXPECT_EQ(bytes(0), "00");
  EXPECT_EQ(bytes(127), "017f");
  EXPECT_EQ(bytes(128), "020080");
  EXPECT_EQ(bytes(-1), "01ff");
  EXPECT_EQ(bytes(-129), "02ff7f");
  EXPECT_EQ(bytes(std::numeric_limits<std::int64_t>::min()), "088000000000000000");
  for (const std::int64_t value : {0L, 1L, -1L, 255L, 256L, -32769L, 1L << 55, -(1L << 62)}) {
    std::string out;
    add_integer(out, value);
    BytesReader reader(out);
    EXPECT_EQ(reader.integer(), value);
    EXPECT_TRUE(reader.good() && reader.at_end());
  }
}

TEST(ValueBytes, ReadNothingBeyondTheirEnd) {
  for (const std::string bytes :
       {"\x08\x01", "\x12\x05", "\x12\x01\x7f", "\x11\x01", "\x13\x01\x80"}) {
    BytesReader reader(bytes);
    reader.value();
    EXPECT_FALSE(reader.good());
  }
}

TEST_F(ChainTest, VerifiesWhatWasStored) {
  store_points(3);
  const auto report = verified();
  EXPECT_EQ(report.differences, 0) << first_found();
  EXPECT_GT(report.rows, 150);
  EXPECT_EQ(report.head, store->audit().head().value());
  EXPECT_EQ(report.head.hash.size(), 64U);
}

TEST_F(ChainTest, GrowsByOneEntryForEachCommit) {
  store_points(1);
  const auto before = store->audit().head()->entry;
  ASSERT_TRUE(store->points().commit(example_commit(run, datum, 1)));
  EXPECT_EQ(store->audit().head()->entry, before + 1);
  ASSERT_TRUE(store->idle());  // summaries are not protected
  EXPECT_EQ(store->audit().head()->entry, before + 1);
}

TEST_F(ChainTest, KeepsNothingOfACommitThatWasRefused) {
  store_points(1);
  const auto before = store->audit().head().value();
  EXPECT_FALSE(store->points().commit(example_commit(run, datum, 0)));
  EXPECT_FALSE(store->points().commit(example_commit(run, DatumId{77}, 1)));
  EXPECT_EQ(store->audit().head().value(), before);
  EXPECT_EQ(first_found(), "nothing");
}

TEST_F(ChainTest, FollowsARowThatChangesByRight) {
  RunChange paused;
  paused.state = RunState::paused;
  paused.reason = "paused by ada";
  ASSERT_TRUE(store->runs().change_run(run, paused));
  EXPECT_EQ(first_found(), "nothing");
}

TEST_F(ChainTest, NamesAValueThatWasChanged) {
  store_points(3);
  change("UPDATE reading_value SET value = value + 1e-9 WHERE reading_id = 5 AND channel_id = 2");
  EXPECT_THAT(first_found(),
              testing::StartsWith("reading_value with reading_id 5, channel_id 2 differs"));
}

TEST_F(ChainTest, NamesARowThatWasRemoved) {
  store_points(3);
  change("DELETE FROM point_value WHERE point_id = 2; DELETE FROM point WHERE point_id = 2");
  EXPECT_THAT(first_found(), testing::StartsWith("point with point_id 2 is missing"));
}

TEST_F(ChainTest, NamesARowThatWasInserted) {
  store_points(2);
  change(
      "INSERT INTO reading (reading_id, device_id, start_ns, end_ns, sequence) VALUES (900, 1, "
      "5, 6, 7)");
  EXPECT_EQ(first_found(), "reading with reading_id 900 is inserted: the chain has no such row");
}

TEST_F(ChainTest, NamesAMoveThatWasInsertedChangedOrRemoved) {
  store_points(5);
  change(
      "INSERT INTO move (at_ns, ordinal, axis, at_monotonic_ns, run_id, from_mm, to_mm, cause) "
      "SELECT at_ns + 1, ordinal, axis, at_monotonic_ns, run_id, from_mm, to_mm, cause FROM move "
      "ORDER BY at_ns LIMIT 1");
  EXPECT_THAT(first_found(), HasSubstr("is inserted: the chain has no such row"));
  change("DELETE FROM move WHERE at_ns = (SELECT min(at_ns) + 1 FROM move)");
  EXPECT_EQ(first_found(), "nothing");
  change("UPDATE move SET cause = 'other' WHERE at_ns = (SELECT max(at_ns) FROM move)");
  EXPECT_THAT(first_found(), HasSubstr("differs since entry "));
  change("DELETE FROM move WHERE at_ns = (SELECT max(at_ns) FROM move)");
  EXPECT_THAT(first_found(), HasSubstr("is missing since entry "));
}

TEST_F(ChainTest, NamesEachRowOfAnInsertedUnitOnce) {
  change(
      "INSERT INTO datum (datum_id, run_id, opened_ns, opened_monotonic_ns, reason) SELECT 99, "
      "run_id, opened_ns, opened_monotonic_ns, reason FROM datum LIMIT 1; INSERT INTO datum_value "
      "SELECT 99, channel_id, value FROM datum_value LIMIT 1; INSERT INTO datum_value SELECT 98, "
      "channel_id, value FROM datum_value LIMIT 1");
  const auto report = verified();
  EXPECT_EQ(report.differences, 3);
  EXPECT_THAT(report.first, testing::Contains(HasSubstr("datum_value with datum_id 98")));
}

TEST_F(ChainTest, NamesARowThatWasPutBackToAnEarlierState) {
  RunChange paused;
  paused.state = RunState::paused;
  ASSERT_TRUE(store->runs().change_run(run, paused));
  change("CREATE TABLE kept AS SELECT * FROM run_progress");
  store = open_store(path);
  store_points(3);
  change("REPLACE INTO run_progress SELECT * FROM kept; DROP TABLE kept");
  EXPECT_THAT(first_found(), HasSubstr("run_progress with run_id 1 differs since entry "));
}

TEST_F(ChainTest, ChecksALargerRecordWithoutMoreMemory) {
  constexpr int kBatch = 100;  // an entry each: the memory is looked at every 500
  int moves = 0;
  const auto add = [&](int batches) {
    for (int batch = 0; batch < batches; ++batch) {
      std::vector<MoveRecord> some;
      for (int i = 0; i < kBatch; ++i, ++moves)
        some.push_back({run, at_s(100 + 0.5 * moves), {1.0}, {2.0}, "point"});
      ASSERT_TRUE(store->readings().append({}, some, {}));
    }
  };
  const auto peak_bytes = [&] {
    const auto checker = open_store(path, true);
    const std::size_t before = mallinfo2().uordblks;
    std::size_t peak = before;
    const auto report = checker->audit().verify({}, [&] {
      peak = std::max(peak, mallinfo2().uordblks);
      return false;
    });
    EXPECT_TRUE(report->intact());
    EXPECT_GE(report->units, moves);
    return static_cast<std::int64_t>(peak - before);
  };
  add(600);
  const auto of_60_000 = peak_bytes();
  add(1200);
  const auto of_180_000 = peak_bytes();
  RecordProperty("bytes_60_000", std::to_string(of_60_000));
  RecordProperty("bytes_180_000", std::to_string(of_180_000));
  EXPECT_LT(of_180_000 - of_60_000, 3 << 20) << of_60_000 << " B, then " << of_180_000 << " B";
}

TEST_F(ChainTest, NamesAnEntryOfTheChainThatWasChanged) {
  store_points(3);
  const auto last = store->audit().head()->entry;
  change("UPDATE chain SET head = zeroblob(32) WHERE entry_id = " + std::to_string(last - 1));
  EXPECT_THAT(first_found(),
              testing::StartsWith("entry " + std::to_string(last - 1) + " of the chain differs"));
  change("DELETE FROM chain WHERE entry_id = " + std::to_string(last - 2));
  EXPECT_EQ(first_found(), "entry " + std::to_string(last - 2) + " of the chain is missing");
}

TEST_F(ChainTest, NamesATriggerThatWasAdded) {
  change(
      "CREATE TRIGGER quiet AFTER INSERT ON reading_value BEGIN UPDATE reading_value SET value "
      "= 0.0 WHERE reading_id = new.reading_id; END");
  EXPECT_EQ(first_found(), "the database has a trigger quiet that no Driftwise made");
}

TEST_F(ChainTest, RefusesACallThatWouldChangeAReading) {
  store_points(1);
  change(
      "CREATE TRIGGER worse AFTER INSERT ON event BEGIN UPDATE reading_value SET value = 0.0; "
      "END");
  store = open_store(path);
  const auto refused =
      store->events().add_event({{}, at_s(9), "ada", "", "note.added", "a remark", {}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "ROWS_NEVER_CHANGE");
}

// Whoever owns the file can remove the chain and have another one made: it is whole, and only the
// head that was kept elsewhere shows it.
TEST_F(ChainTest, FindsAChainComputedAnewByTheHeadThatWasKept) {
  store_points(3);
  const auto kept = store->audit().head().value();
  store_points(0);
  change("UPDATE point_value SET value = value + 0.001 WHERE point_id = 1; DELETE FROM chain");
  store = open_store(path);  // begins a chain over what is there
  EXPECT_EQ(first_found(), "nothing");
  const auto report = verified(kept);
  ASSERT_FALSE(report.intact());
  EXPECT_THAT(report.first.front(), testing::AnyOf(testing::HasSubstr("was written anew"),
                                                   testing::HasSubstr("is missing")));
}

TEST_F(ChainTest, FindsThatTheNewestRowsWereRemovedWithTheirEntries) {
  store_points(1);
  ASSERT_TRUE(store->events().add_event({{}, at_s(9), "ada", "", "stop", "ada stopped", {}}));
  const auto kept = store->audit().head().value();
  change("DELETE FROM event; DELETE FROM chain WHERE entry_id = " + std::to_string(kept.entry));
  EXPECT_EQ(first_found(), "nothing");
  EXPECT_THAT(verified(kept).first.front(), testing::HasSubstr("whose head was kept, is missing"));
}

TEST_F(ChainTest, HoldsAnOldHeadAgainstALongerRecord) {
  store_points(1);
  const auto kept = store->audit().head().value();
  store->points().commit(example_commit(run, datum, 1)).value();
  EXPECT_TRUE(verified(kept).intact());
}

TEST(Chain, BeginsOverADatabaseThatHadNone) {
  const TemporaryFolder folder;
  const std::string path = copy_of_version_1_cell(folder);
  auto store = open_store(path);
  const auto report = store->audit().verify({}, {}).value();
  EXPECT_TRUE(report.intact()) << report.first.front();
  EXPECT_GT(report.rows, 500);
  const auto head = store->audit().head().value();
  store.reset();
  EXPECT_EQ(open_store(path)->audit().head().value(), head) << "begins once";
}

// Rows in more than one step and more than one entry.
TEST_F(ChainTest, VerifiesAnImportOfThousandsOfRows) {
  Dataset dataset;
  dataset.rows = 3000;
  DatasetColumn column{parse_channel("x_mm").value(), {}};
  for (std::size_t row = 0; row < dataset.rows; ++row)
    column.values.push_back(static_cast<double>(row) / 7);
  dataset.columns.push_back(column);
  ASSERT_TRUE(store->runs().import_dataset(example_run("import"), dataset));
  const auto report = verified();
  EXPECT_TRUE(report.intact()) << report.first.front();
  change("UPDATE point_value SET value = 1.5 WHERE point_id = 2222");
  EXPECT_THAT(first_found(), testing::StartsWith("point_value with point_id 2222, channel_id"));
}

TEST_F(ChainTest, KeepsActsWithTheEventThatTellsOfThem) {
  AuditRecord act;
  act.at = at_s(3);
  act.by = {"ada", "stated", "ipv4:127.0.0.1:5020"};
  act.what = "model.promote";
  act.subject = "model 2";
  act.before = "model 1";
  act.after = "model 2";
  const auto stored = store->audit().add(
      act, EventRecord{{}, at_s(3), "ada", "", "model.promote", "model 2 serves", {}});
  ASSERT_TRUE(stored) << stored.error().message;
  act.what = "run.abort";
  act.outcome = "a viewer may not abort a run";
  ASSERT_TRUE(store->audit().add(act, {}));
  const auto acts = store->audit().acts(0, 10).value();
  ASSERT_EQ(acts.size(), 2U);
  EXPECT_EQ(acts[0].outcome, "a viewer may not abort a run");
  EXPECT_EQ(acts[0].event.value, 0);
  EXPECT_EQ(acts[1].by.proof, "stated");
  EXPECT_EQ(acts[1].event, store->events().events({0}, 0)->back().id);
  EXPECT_EQ(store->audit().acts(acts[0].id, 10)->size(), 1U);
  EXPECT_EQ(first_found(), "nothing");
}

TEST(ChainHead, ReadsBackAsItIsWritten) {
  const ChainHead head{812, std::string(64, 'a')};
  EXPECT_EQ(chain_head_from(to_string(head)), head);
  for (const auto& wrong : {std::string(), std::string(64, 'a'), std::string(64, 'a') + "@",
                            std::string(64, 'a') + "@0", std::string(64, 'A') + "@1",
                            std::string(63, 'a') + "@12", std::string(64, 'a') + "@1x"})
    EXPECT_FALSE(chain_head_from(wrong)) << wrong;
}

}  // namespace
}  // namespace driftwise::storage
