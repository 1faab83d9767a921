// A disk that is full for a while: the run waits, says so, and loses nothing.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "server/application/plumbing/store_writer.h"
#include "storage/sqlite_store.h"
#include "tests/support/cell_in_memory.h"

namespace driftwise::tests {
namespace {

const Error kNoRoom{ErrorCode::resource_exhausted, "DISK_FULL", "the disk is full: make room"};

// Passes everything on, but refuses commits while the disk is full, or marks alone.
class FullDisk final : public Store,
                       RunStore,
                       PointStore,
                       ReadingStore,
                       EventStore,
                       AuditStore,
                       StopStore,
                       RemarkStore {
 public:
  FullDisk(std::unique_ptr<Store> inner, const bool& full, const bool& no_marks,
           Error refusal = kNoRoom)
      : Store(before(*inner, this)),
        inner_(std::move(inner)),
        full_(full),
        no_marks_(no_marks),
        refusal_(std::move(refusal)) {}

 private:
  // Asked before its own bases stand: a static function, for nothing of it may be called yet.
  static StoreParts before(Store& inner, FullDisk* its) {
    StoreParts parts = inner.parts();
    parts.runs = its;
    parts.points = its;
    parts.readings = its;
    parts.events = its;
    parts.audit = its;
    parts.stops = its;
    parts.remarks = its;
    parts.upkeep = nullptr;
    return parts;
  }
  template <class T>
  Result<T> or_full(std::function<Result<T>()> call) {
    if (full_) return tl::unexpected(refusal_);
    return call();
  }
  Result<RunRecord> create_run(const NewRun& run) override {
    return or_full<RunRecord>([&] { return inner_->runs().create_run(run); });
  }
  Result<void> change_run(RunId run, const RunChange& change) override {
    return or_full<void>([&] { return inner_->runs().change_run(run, change); });
  }
  Result<DatumId> open_datum(const DatumRecord& datum) override {
    return or_full<DatumId>([&] { return inner_->points().open_datum(datum); });
  }
  Result<std::optional<PointId>> commit(const PointCommit& commit) override {
    return or_full<std::optional<PointId>>([&] { return inner_->points().commit(commit); });
  }
  Result<RunRecord> run(RunId run) override { return inner_->runs().run(run); }
  Result<std::vector<RunRecord>> runs(int limit, std::int64_t before) override {
    return inner_->runs().runs(limit, before);
  }
  Result<std::optional<RunRecord>> unfinished_run() override {
    return inner_->runs().unfinished_run();
  }
  Result<std::vector<PointRecord>> points(RunId run, std::int64_t after, int limit) override {
    return inner_->points().points(run, after, limit);
  }
  Result<std::vector<AttemptRecord>> attempts(RunId run) override {
    return inner_->points().attempts(run);
  }
  Result<std::vector<DatumRecord>> data(RunId run) override { return inner_->points().data(run); }
  Result<std::optional<DatumRecord>> newest_datum() override {
    return inner_->points().newest_datum();
  }
  Result<RunRecord> import_dataset(const NewRun& run, const Dataset& data) override {
    return or_full<RunRecord>([&] { return inner_->runs().import_dataset(run, data); });
  }
  Result<Dataset> dataset(std::span<const RunId> runs) override {
    return inner_->runs().dataset(runs);
  }
  Result<void> append(std::span<const Reading> readings, std::span<const MoveRecord> moves,
                      std::span<const RejectedAnswer> rejected) override {
    return or_full<void>([&] { return inner_->readings().append(readings, moves, rejected); });
  }
  Result<std::vector<Reading>> readings(const std::string& device, CellTime from, CellTime to,
                                        int limit) override {
    return inner_->readings().readings(device, from, to, limit);
  }
  Result<std::vector<MoveRecord>> moves(CellTime from, CellTime to) override {
    return inner_->readings().moves(from, to);
  }
  Result<EventId> add_event(const EventRecord& event) override {
    return or_full<EventId>([&] { return inner_->events().add_event(event); });
  }
  Result<std::vector<EventRecord>> events(EventId after, int limit) override {
    return inner_->events().events(after, limit);
  }

  Result<AuditRecord> add(const AuditRecord& act,
                          const std::optional<EventRecord>& event) override {
    return or_full<AuditRecord>([&] { return inner_->audit().add(act, event); });
  }
  Result<std::vector<StopRecord>> keep(std::span<const StopRecord> stops) override {
    return or_full<std::vector<StopRecord>>([&] { return inner_->stops().keep(stops); });
  }
  Result<bool> confirm(const StopRecord& stop, CellTime at) override {
    return or_full<bool>([&] { return inner_->stops().confirm(stop, at); });
  }
  Result<std::vector<StopRecord>> pending() override { return inner_->stops().pending(); }
  Result<ExclusionRecord> exclude(const ExclusionRecord& exclusion) override {
    if (no_marks_) return fail(ErrorCode::resource_exhausted, "DISK_FULL", "no room for a mark");
    return or_full<ExclusionRecord>([&] { return inner_->remarks().exclude(exclusion); });
  }
  Result<std::vector<ExclusionRecord>> exclusions(RunId run) override {
    return inner_->remarks().exclusions(run);
  }
  Result<NoteRecord> add_note(const NoteRecord& note) override {
    return or_full<NoteRecord>([&] { return inner_->remarks().add_note(note); });
  }
  Result<std::vector<NoteRecord>> notes(const NoteSubject& subject) override {
    return inner_->remarks().notes(subject);
  }
  Result<TimeNoteRecord> add_time_note(const TimeNoteRecord& note) override {
    return or_full<TimeNoteRecord>([&] { return inner_->remarks().add_time_note(note); });
  }
  Result<std::vector<TimeNoteRecord>> time_notes(CellTime from, CellTime to, int limit) override {
    return inner_->remarks().time_notes(from, to, limit);
  }
  Result<std::vector<AuditRecord>> acts(std::int64_t before_id, int limit) override {
    return inner_->audit().acts(before_id, limit);
  }
  Result<ChainHead> head() override { return inner_->audit().head(); }
  Result<ChainReport> verify(const std::optional<ChainHead>& outside,
                             const std::function<bool()>& give_way) override {
    return inner_->audit().verify(outside, give_way);
  }
  std::string record_in(const std::string& path) override {
    return inner_->audit().record_in(path);
  }
  Result<RecordCopy> back_up(const std::string& path,
                             const std::function<bool()>& give_way) override {
    return or_full<RecordCopy>([&] { return inner_->audit().back_up(path, give_way); });
  }
  Result<ThinningStep> thin(const ThinningOrder& order) override {
    return or_full<ThinningStep>([&] { return inner_->audit().thin(order); });
  }

  std::unique_ptr<Store> inner_;
  const bool &full_, &no_marks_;
  const Error refusal_;
};

class FullDiskTest : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  bool full = false, no_marks = false;
  OpenStore open = [this](const std::string& path,
                          bool read_only) -> Result<std::unique_ptr<Store>> {
    auto store = storage::open_sqlite_store(path, read_only);
    if (!store || read_only) return store;
    return std::make_unique<FullDisk>(std::move(*store), full, no_marks);
  };
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), open};
};

TEST_F(FullDiskTest, TheRunWaitsWithTheSentenceAndLosesNothing) {
  cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  full = true;
  cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  EXPECT_EQ(cell.status().run->run.reason, "the disk is full: make room");
  const int scans_before = world.scans;
  const auto moves_before = world.moves;
  cell.pass(900);
  EXPECT_EQ(cell.status().run->run.accepted, 3);
  EXPECT_EQ(world.moves, moves_before);
  full = false;
  const auto ended = cell.finish_run();
  EXPECT_EQ(ended.state, RunState::done);
  const auto points = *cell.await(cell.points(ended.id, 0, 100));
  ASSERT_EQ(points.size(), 8u);
  // The scans of the full quarter of an hour are there too.
  cell.pass(20);
  EXPECT_GE(world.scans - scans_before, 170);
  auto store = *storage::open_sqlite_store(folder / "cell.sqlite", true);
  const auto stored = *store->readings().readings("scanner", kWorldBegin, cell.now(), 100'000);
  EXPECT_GE(static_cast<int>(stored.size()) + 5, world.scans);
  EXPECT_EQ(cell.events_named("run.done").size(), 1u);
  // The record says why the run stood, and that it went on.
  EXPECT_EQ(cell.events_named("run.trouble"),
            std::vector<std::string>{"the disk is full: make room"});
  EXPECT_EQ(cell.events_named("run.resumed").size(), 1u);
}

TEST_F(FullDiskTest, NothingIsZeroedBeforeItTakesThatTheOldZeroGoes) {
  const auto run = cell.begin_run(lines_of(2, {2, -3, 1}, true)).id;
  cell.until([&] { return world.homes == 1; });
  full = true;
  cell.until([&] { return cell.status().run->run.reason == "the disk is full: make room"; });
  EXPECT_EQ(cell.status().run->run.state, RunState::waiting);
  cell.pass(900);
  EXPECT_EQ(world.zeroings, 0);
  full = false;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(world.zeroings, 1);
  EXPECT_EQ(cell.await(cell.datums(run))->size(), 1u);
}

TEST_F(FullDiskTest, ADatumWaitsForItAndTheInstrumentsAreNotZeroedAgain) {
  const auto run = cell.begin_run(lines_of(2, {2, -3, 1}, true)).id;
  cell.until([&] { return world.zeroings == 1; });
  const auto zeroed = cell.now();
  full = true;
  cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  EXPECT_EQ(cell.status().run->run.reason, "the disk is full: make room");
  cell.pass(900);
  full = false;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(world.zeroings, 1);
  const auto data = *cell.await(cell.datums(run));
  ASSERT_EQ(data.size(), 1u);
  EXPECT_LT(data.front().opened.utc, zeroed + std::chrono::seconds(60)) << "of the zeroing itself";
  EXPECT_EQ(cell.events_named("run.trouble"),
            std::vector<std::string>{"the disk is full: make room"});
  EXPECT_EQ(cell.events_named("run.resumed").size(), 1u);
}

// Lines of a return to zero and four points: rows 0 and 1..4, 5 and 6..9, ...
TEST_F(FullDiskTest, AMarkWaitsForItThroughAStopAndTheRunIsPausedThen) {
  const auto run = cell.begin_run(lines_of(5, {2, -3, 1, -1}, true)).id;
  cell.until([&] { return cell.status().run->run.accepted >= 8; });
  world.zero_mm -= 0.010;
  no_marks = true;
  cell.until([&] { return cell.status().run->run.reason == "no room for a mark"; });
  ASSERT_TRUE(cell.await(cell->manual.stop_all(cell.ada)));
  const int moves = world.moves;
  cell.pass(60);
  EXPECT_EQ(world.moves, moves);
  no_marks = false;
  cell.until([&] { return cell.status().run->run.state == RunState::paused; }, 60);
  EXPECT_EQ(cell.await(cell->annotations.exclusions(run))->suspect_rows,
            (std::vector<std::int64_t>{6, 7, 8, 9, 10}));
  EXPECT_EQ(world.moves, moves);
  ASSERT_TRUE(cell.resume());
  EXPECT_EQ(cell.finish_run().state, RunState::done);
}

struct Halt {
  const char* name;
  bool stop;  // of the axes; false: a pause of the run
};
class HaltOnAFullDisk : public FullDiskTest, public testing::WithParamInterface<Halt> {
 protected:
  RunId halt_a_waiting_run() {
    const auto id = cell.begin_run(lines_of(2, {2, -3, 1}, true)).id;
    cell.until([&] { return cell.status().run->run.accepted == 3; });
    full = true;
    cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
    if (GetParam().stop) {
      EXPECT_TRUE(cell.await(cell->manual.stop_all(cell.ada)));
      cell.until([&] { return cell.status().run->run.state == RunState::paused; });
    } else {  // in force when the point under way is on record
      EXPECT_TRUE(cell.await(cell->runs.pause(cell.ada, id)));
    }
    return id;
  }
  RunState on_record(RunId id) {
    return (*storage::open_sqlite_store(folder / "cell.sqlite", true))->runs().run(id)->state;
  }
};

TEST_P(HaltOnAFullDisk, IsOnRecordAsSoonAsThereIsRoom) {
  const auto id = halt_a_waiting_run();
  EXPECT_NE(on_record(id), RunState::paused);
  full = false;
  cell.pass(20);
  EXPECT_EQ(on_record(id), RunState::paused) << "a kill now would let it go on";
}

TEST_P(HaltOnAFullDisk, IsToldByACellThatEndsWithoutRoom) {
  const auto id = halt_a_waiting_run();
  cell.shut_down();
  const auto halt = cell.halt_not_on_record();
  ASSERT_TRUE(halt) << "the next start would let run " << id.value << " go on";
  EXPECT_EQ(halt->who, "ada");
}

TEST_P(HaltOnAFullDisk, IsNoSecretOnceItIsOnRecord) {
  halt_a_waiting_run();
  full = false;
  cell.pass(20);
  cell.shut_down();
  EXPECT_FALSE(cell.halt_not_on_record());
}

INSTANTIATE_TEST_SUITE_P(By, HaltOnAFullDisk,
                         testing::Values(Halt{"Stop", true}, Halt{"Pause", false}),
                         [](const auto& row) { return std::string(row.param.name); });

// The next start goes by the record alone: without a run nothing else says that somebody stopped.
TEST_F(FullDiskTest, AStopWithoutARunIsWrittenAgainUntilItIsOnRecord) {
  cell.pass(10);
  full = true;
  const auto answer = cell.await(cell->manual.stop_all(cell.ada));
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->confirmed) << "by the controller";
  EXPECT_THAT(answer->message, testing::HasSubstr("not on record yet: the disk is full"));
  cell.pass(60);
  const auto lease = cell.lease();
  const auto moved = cell.await(cell->manual.move_to(cell.ada, lease, {1}, {}));
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().reason, "STOP_PENDING");
  EXPECT_EQ(cell.await(cell->queue.release(cell.ada)).error().reason, "STOP_PENDING");
  full = false;
  cell.pass(10);
  const auto record = *storage::open_sqlite_store(folder / "cell.sqlite", true);
  EXPECT_TRUE(record->queue().queue(10)->hold.held) << "the next start would begin the queue";
  EXPECT_TRUE(record->stops().pending()->empty()) << "confirmed";
  EXPECT_EQ(cell.events_named("stop").size(), 1u);
  EXPECT_TRUE(cell.await(cell->queue.release(cell.ada)));
  EXPECT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
}

TEST_F(FullDiskTest, AStopWithoutARunIsToldByACellThatEndsWithoutRoom) {
  full = true;
  ASSERT_TRUE(cell.await(cell->manual.stop_all(cell.ada)));
  cell.pass(60);
  cell.shut_down();
  const auto halt = cell.halt_not_on_record();
  ASSERT_TRUE(halt) << "the next start would begin the queue";
  EXPECT_EQ(halt->who, "ada");
}

TEST_F(FullDiskTest, AMovementByHandIsNotBegunWithoutARecordOfIt) {
  ASSERT_TRUE(cell.await(cell->manual.home(cell.ada, cell.lease())));
  const int moves = world.moves;
  const auto lease = cell.lease();
  full = true;
  const auto moved = cell.await(cell->manual.move_to(cell.ada, lease, {1}, {}));
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().reason, "DISK_FULL");
  EXPECT_EQ(cell.await(cell->manual.home(cell.ada, lease)).error().reason, "DISK_FULL");
  EXPECT_EQ(world.moves, moves);
  full = false;
  EXPECT_TRUE(cell.await(cell->manual.move_to(cell.ada, lease, {1}, {})));
  cell.pass(20);
  EXPECT_EQ(cell.events_named("axes.move").size(), 1u) << "the refused one is not on record";
}

// Another program holds the database: like a full disk that passes.
class LockedDatabase : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  bool locked = false, no_marks = false;
  OpenStore open = [this](const std::string& path,
                          bool read_only) -> Result<std::unique_ptr<Store>> {
    auto store = storage::open_sqlite_store(path, read_only);
    if (!store || read_only) return store;
    return std::make_unique<FullDisk>(
        std::move(*store), locked, no_marks,
        Error{ErrorCode::failed_precondition, "DATABASE_LOCKED", "another program holds it"});
  };
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), open};

  RunState on_record(RunId id) {
    return (*storage::open_sqlite_store(folder / "cell.sqlite", true))->runs().run(id)->state;
  }
  // Locked from its last point on.
  RunId finish_a_run_that_is_not_stored() {
    const auto id = cell.begin_run(lines_of(1, {2, -3, 1}, true)).id;
    cell.until([&] { return cell.status().run->run.accepted == 4; });
    locked = true;
    cell.until([&] { return cell.status().run && is_over(cell.status().run->run.state); });
    return id;
  }
};

TEST_F(LockedDatabase, MakesARunWaitWhichLosesNothing) {
  const auto id = cell.begin_run(lines_of(2, {2, -3, 1}, true)).id;
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  locked = true;
  cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  cell.pass(300);
  locked = false;
  EXPECT_EQ(cell.finish_run().state, RunState::done);
  EXPECT_EQ(cell.await(cell.points(id, 0, 100))->size(), 8u);
}

TEST_F(LockedDatabase, KeepsARunUnderWayUntilItsEndIsOnRecord) {
  const auto id = finish_a_run_that_is_not_stored();
  cell.pass(300);
  ASSERT_TRUE(cell.status().run) << "still under way";
  EXPECT_EQ(cell.status().run->phase, "waiting until its end is on record");
  EXPECT_NE(on_record(id), RunState::done);
  locked = false;
  cell.pass(30);
  EXPECT_EQ(on_record(id), RunState::done);
  EXPECT_FALSE(cell.status().run);
}

TEST_F(LockedDatabase, EndsWithAStopForTheNextStartWhereTheEndOfARunIsNotOnRecord) {
  const auto id = finish_a_run_that_is_not_stored();
  cell.pass(300);
  cell.shut_down();
  EXPECT_TRUE(cell.halt_not_on_record())
      << "the next start would drive the robot for run " << id.value << ", which is over";
}

TEST_F(LockedDatabase, DelaysTheRecordOfAnActAndLosesNone) {
  locked = true;
  static_cast<void>(cell.lease());
  cell.pass(60);
  locked = false;
  cell.pass(20);
  EXPECT_EQ(cell.events_named("lease.taken").size(), 1u);
  const auto acts = cell.await(cell.read([](Store& store) { return store.audit().acts(0, 100); }));
  EXPECT_EQ(std::ranges::count(*acts, "lease.taken", &AuditRecord::what), 1);
}

// The database is damaged: what people did will never be on record, and they are told.
TEST(ActsThatAreLost, RaiseAnAlarm) {
  Folder folder;
  SmallWorld world;
  bool damaged = false, no_marks = false;
  const OpenStore open = [&](const std::string& path,
                             bool read_only) -> Result<std::unique_ptr<Store>> {
    auto store = storage::open_sqlite_store(path, read_only);
    if (!store || read_only) return store;
    return std::make_unique<FullDisk>(
        std::move(*store), damaged, no_marks,
        Error{ErrorCode::data_loss, "DATABASE_DAMAGED", "the file is damaged"});
  };
  CellInMemory cell{world, small_cell(folder / "cell.sqlite"), open};
  cell.pass(10);
  damaged = true;
  static_cast<void>(cell.lease());
  cell.pass(20);
  const auto alarms = cell.alarms_of("record.dropped");
  ASSERT_EQ(alarms.size(), 1u);
  EXPECT_THAT(alarms.front(), testing::HasSubstr("1 acts of people"));
}

TEST(ReadingsOnAFullDisk, KeepTheirOrderWhenTwoParcelsAreRefusedAtATime) {
  Folder folder;
  const bool full = true, no_marks = false;
  asio::io_context cell, storage_thread;
  application::StoreWriter writer{
      storage_thread.get_executor(),
      std::make_unique<FullDisk>(*storage::open_sqlite_store(folder / "cell.sqlite", false), full,
                                 no_marks)};
  const auto add_at_s = [&writer](int seconds) {
    Reading reading;
    reading.device = "scanner";
    reading.start = reading.end = kWorldBegin + std::chrono::seconds(seconds);
    writer.add(std::move(reading));
  };
  int refused = 0;
  const auto count = [&refused](const std::exception_ptr&, const auto& stored) {
    refused += !stored;
  };
  add_at_s(10);
  asio::co_spawn(cell, writer.commit({}), count);
  cell.poll();  // handed over, and not looked at yet
  add_at_s(20);
  asio::co_spawn(cell, writer.flush(), count);
  cell.poll();
  ASSERT_EQ(writer.gathered(), 0u) << "both are on their way";
  while (refused < 2) {
    storage_thread.restart();
    cell.restart();
    ASSERT_GT(storage_thread.poll() + cell.poll(), 0u);
  }
  EXPECT_EQ(writer.gathered(), 2u);
  EXPECT_EQ(writer.gathered_since(), kWorldBegin + std::chrono::seconds(10))
      << "the alarm goes by the oldest";
}

TEST_F(FullDiskTest, ShutDownDoesNotWaitForRoom) {
  cell.begin_run(lines_of(2, {2, -3, 1}, true));
  cell.until([&] { return cell.status().run->run.accepted == 3; });
  full = true;
  cell.until([&] { return cell.status().run->run.state == RunState::waiting; });
  cell.shut_down();
  full = false;
}

}  // namespace
}  // namespace driftwise::tests
