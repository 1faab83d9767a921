// Alarms from their beginning to their end: one that flickers is one, one that was acknowledged
// stays so over a restart, and a full disk loses none.

#include "server/application/alarms/alarm_book.h"

#include <gmock/gmock.h>

#include <boost/asio/io_context.hpp>

#include "tests/support/cell_in_memory.h"
#include "tests/support/manual_clock.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::application {
namespace {

using testing::IsEmpty;
using tests::kSqlite;
using Conditions = std::vector<AlarmCondition>;

// The alarms of a store that fails when it is told to.
class FullDisk final : public AlarmStore {
 public:
  explicit FullDisk(AlarmStore& under) : under_(under) {}
  bool full = false;

  Result<AlarmRecord> raise(const AlarmRecord& alarm) override {
    if (full) return refused();
    return under_.raise(alarm);
  }
  Result<AlarmRecord> tell(AlarmId id, const std::string& message,
                           const std::vector<std::string>& consequences) override {
    if (full) return refused();
    return under_.tell(id, message, consequences);
  }
  Result<AlarmRecord> clear(AlarmId id, CellTime at) override {
    if (full) return refused();
    return under_.clear(id, at);
  }
  Result<AlarmRecord> acknowledge(AlarmId id, CellTime at, const std::string& who) override {
    if (full) return refused();
    return under_.acknowledge(id, at, who);
  }
  Result<std::vector<AlarmRecord>> alarms(bool with_history, int limit) override {
    return under_.alarms(with_history, limit);
  }
  Result<AlarmRecord> shelve(AlarmId id, const AlarmShelf& shelf) override {
    if (full) return refused();
    return under_.shelve(id, shelf);
  }
  Result<AlarmRecord> unshelve(AlarmId id, CellTime at) override {
    if (full) return refused();
    return under_.unshelve(id, at);
  }
  Result<std::vector<AlarmRecord>> end_shelves(CellTime now) override {
    if (full) return refused();
    return under_.end_shelves(now);
  }

 private:
  static tl::unexpected<Error> refused() {
    return fail(ErrorCode::resource_exhausted, "DISK_FULL", "no room");
  }
  AlarmStore& under_;
};

// A store whose alarms stand behind that disk.
class AlarmsOnly final : public Store {
 public:
  explicit AlarmsOnly(std::unique_ptr<Store> under)
      : Store(before(*under, disk)), under_(std::move(under)), disk(under_->alarms()) {}

 private:
  static StoreParts before(Store& under, FullDisk& disk) {
    StoreParts parts = under.parts();
    parts.alarms = &disk;
    parts.upkeep = nullptr;
    return parts;
  }

  std::unique_ptr<Store> under_;

 public:
  FullDisk disk;
};

class AlarmBookTest : public testing::Test {
 protected:
  AlarmBookTest() { open(); }

  // As a start of the daemon does: what stands in the store is taken up.
  void open() {
    book.reset();
    writer.reset();
    store = nullptr;
    auto opened = std::make_unique<AlarmsOnly>(kSqlite(folder / "cell.sqlite", false).value());
    store = opened.get();
    writer = std::make_unique<StoreWriter>(io.get_executor(), std::move(opened));
    book = std::make_unique<AlarmBook>(clock, *writer);
    hearing = book->watchers().add([this](const AlarmRecord& alarm) { heard.push_back(alarm); });
    EXPECT_TRUE(done(book->restore()));
  }
  template <class T>
  T done(Awaitable<T> call) {
    std::optional<T> answer;
    asio::co_spawn(io, std::move(call),
                   [&](std::exception_ptr, T value) { answer = std::move(value); });
    io.restart();
    io.run();
    return std::move(answer.value());
  }
  void done(Awaitable<void> call) {
    asio::co_spawn(io, std::move(call), [](std::exception_ptr bug) { EXPECT_FALSE(bug); });
    io.restart();
    io.run();
  }
  void look(const Conditions& conditions, AlarmBook::IsJudged is_judged = {}) {
    clock.advance(nanoseconds_from_s(2));
    done(book->look(conditions, std::move(is_judged)));
  }
  std::vector<AlarmRecord> standing() { return store->alarms().alarms(false, 100).value(); }

  tests::Folder folder;
  asio::io_context io;
  tests::ManualClock clock;
  AlarmsOnly* store = nullptr;
  std::unique_ptr<StoreWriter> writer;
  std::unique_ptr<AlarmBook> book;
  std::shared_ptr<void> hearing;
  std::vector<AlarmRecord> heard;
};

AlarmCondition lost(const std::string& device) {
  return {AlarmLevel::failed, "device.lost", device, device + " does not answer"};
}

TEST_F(AlarmBookTest, AConditionThatLastsIsOneAlarm) {
  for (int i = 0; i < 5; ++i) look({lost("laser-x")});
  ASSERT_EQ(standing().size(), 1u);
  EXPECT_EQ(standing()[0].subject, "laser-x");
  EXPECT_EQ(standing()[0].cleared.utc_ns, 0);
  EXPECT_EQ(heard.size(), 1u) << "told once";
}

TEST_F(AlarmBookTest, OneThatFlickersIsOneAlarm) {
  for (int i = 0; i < 6; ++i) look(i % 3 == 0 ? Conditions{lost("laser-x")} : Conditions{});
  ASSERT_EQ(standing().size(), 1u) << "two looks without it are not its end";
  EXPECT_EQ(standing()[0].cleared.utc_ns, 0);
}

TEST_F(AlarmBookTest, ThreeLooksWithoutItAreItsEndAndItsReturnIsAnother) {
  look({lost("laser-x")});
  for (int i = 0; i < AlarmBook::kLooksToClear; ++i) look({});
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_GT(heard[1].cleared, heard[0].since);
  look({lost("laser-x")});
  ASSERT_EQ(standing().size(), 2u) << "nobody has acknowledged the first";
  EXPECT_NE(standing()[0].id, standing()[1].id);
}

TEST_F(AlarmBookTest, TheSameKindOfTwoDevicesAreTwo) {
  look({lost("laser-x"), lost("scanner")});
  EXPECT_EQ(standing().size(), 2u);
  look({lost("scanner")});
  look({lost("scanner")});
  look({lost("scanner")});
  const auto all = standing();
  EXPECT_EQ(std::ranges::count_if(all, [](const auto& a) { return a.cleared.utc_ns == 0; }), 1);
}

TEST_F(AlarmBookTest, WhatHoldsAtARestartGoesOnAndStaysAcknowledged) {
  look({lost("laser-x")});
  const AlarmId id = standing()[0].id;
  const auto acknowledged = done(book->acknowledge(id, "ada"));
  ASSERT_TRUE(acknowledged);
  EXPECT_EQ(acknowledged->acknowledged_by, "ada");
  open();
  look({lost("laser-x")});
  ASSERT_EQ(standing().size(), 1u) << "not a second one";
  EXPECT_EQ(standing()[0].id, id);
  EXPECT_EQ(standing()[0].acknowledged_by, "ada");
}

TEST_F(AlarmBookTest, WhatEndedWhileTheDaemonWasAwayIsClearedAfterIt) {
  look({lost("laser-x")});
  ASSERT_TRUE(done(book->acknowledge(standing()[0].id, "ada")));
  open();
  for (int i = 0; i < AlarmBook::kLooksToClear; ++i) look({});
  EXPECT_THAT(standing(), IsEmpty());
}

// A source that has not looked since the start is silent, and its silence ends nothing.
TEST_F(AlarmBookTest, AnAlarmOfBeforeTheStartStandsUntilItsSourceHasJudged) {
  look({lost("laser-x")});
  look({lost("laser-x"), lost("scanner")});
  open();
  heard.clear();
  bool judged = false;
  const auto is_judged = [&judged](const AlarmRecord& alarm) {
    return alarm.subject != "scanner" || judged;
  };
  for (int i = 0; i < 10 * AlarmBook::kLooksToClear; ++i) look({lost("laser-x")}, is_judged);
  EXPECT_THAT(heard, IsEmpty());
  ASSERT_EQ(book->unjudged().size(), 1u);
  EXPECT_EQ(book->unjudged()[0].subject, "scanner");
  judged = true;
  for (int i = 0; i < AlarmBook::kLooksToClear; ++i) look({}, is_judged);
  EXPECT_EQ(heard.size(), 2u) << "both are over";
  EXPECT_THAT(book->unjudged(), IsEmpty());
}

TEST_F(AlarmBookTest, WhatHoldsIsTakenUpHoweverManyNobodyHasAcknowledged) {
  constexpr int kMany = 10'001;  // one more than a list of alarms holds
  look({lost("laser-x")});
  AlarmRecord over;
  over.kind = "run.failed";
  over.subject = "run 3";
  over.since = over.cleared = clock.now().utc;
  for (int i = 0; i < kMany; ++i) ASSERT_TRUE(store->alarms().raise(over));
  open();
  look({lost("laser-x")});
  const auto holding = [this] {
    auto alarms = store->alarms().alarms(false, 0).value();
    std::erase_if(alarms, [](const AlarmRecord& alarm) { return alarm.cleared.utc_ns != 0; });
    return alarms.size();
  };
  EXPECT_EQ(holding(), 1u) << "not a second one";
  for (int i = 0; i < AlarmBook::kLooksToClear; ++i) look({});
  EXPECT_EQ(holding(), 0u) << "it ends";
}

TEST_F(AlarmBookTest, WhatIsOverAtOnceStandsUntilSomebodyHasSeenIt) {
  done(book->note({AlarmLevel::failed, "run.failed", "run 3", "run 3 failed: door open"}));
  for (int i = 0; i < 5; ++i) look({});
  ASSERT_EQ(standing().size(), 1u);
  EXPECT_EQ(standing()[0].cleared, standing()[0].since);
  ASSERT_TRUE(done(book->acknowledge(standing()[0].id, "bob")));
  EXPECT_THAT(standing(), IsEmpty());
}

TEST_F(AlarmBookTest, AFullDiskDelaysTheRecordAndNotTheTelling) {
  store->disk.full = true;
  look({lost("laser-x")});
  ASSERT_EQ(heard.size(), 1u) << "at once";
  EXPECT_EQ(heard[0].id.value, 0);
  look({lost("laser-x")});
  EXPECT_EQ(heard.size(), 1u) << "and once";
  store->disk.full = false;
  look({lost("laser-x")});
  ASSERT_EQ(standing().size(), 1u);
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[1].id, standing()[0].id) << "with its number";
  EXPECT_EQ(heard[1].since, heard[0].since) << "by which it is known";
  store->disk.full = true;
  for (int i = 0; i < 5; ++i) look({});
  EXPECT_EQ(standing()[0].cleared.utc_ns, 0) << "its end could not be written";
  ASSERT_EQ(heard.size(), 3u) << "and is told all the same, once";
  EXPECT_NE(heard[2].cleared.utc_ns, 0);
  EXPECT_EQ(heard[2].id, heard[1].id);
  ASSERT_EQ(book->outdated().size(), 1u) << "who comes meanwhile is told too";
  EXPECT_EQ(book->outdated()[0].cleared, heard[2].cleared);
  store->disk.full = false;
  look({});
  EXPECT_EQ(standing()[0].cleared, heard[2].cleared);
  EXPECT_THAT(book->outdated(), IsEmpty());
}

TEST_F(AlarmBookTest, AFullDiskKeepsBackNoNewSentence) {
  AlarmCondition hot{AlarmLevel::warning, "channel.beyond", "t01_degC", "t01 is at 31 degC"};
  look({hot});
  store->disk.full = true;
  hot.message = "t01 is at 48 degC";
  hot.consequences = {"run 3 waits"};
  look({hot});
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[1].message, hot.message);
  EXPECT_EQ(heard[1].consequences, hot.consequences);
  ASSERT_EQ(book->outdated().size(), 1u);
  EXPECT_EQ(book->outdated()[0].message, hot.message);
  store->disk.full = false;
  look({hot});
  EXPECT_EQ(standing()[0].message, hot.message) << "on record as soon as there is room";
  EXPECT_THAT(book->outdated(), IsEmpty());
}

// The full disk is such a one: when its alarm can be written, the disk is full no longer.
TEST_F(AlarmBookTest, AnAlarmThatWasOverBeforeItCouldBeWrittenIsOnRecordWithItsBeginningAndEnd) {
  store->disk.full = true;
  look({lost("laser-x")});
  ASSERT_EQ(book->unstored().size(), 1u) << "whoever asks meanwhile is told";
  const CellTime since = book->unstored()[0].since;
  EXPECT_EQ(since, clock.now().utc);
  look({lost("laser-x")});
  EXPECT_EQ(book->unstored().size(), 1u);
  for (int i = 0; i < AlarmBook::kLooksToClear; ++i) look({});
  store->disk.full = false;
  look({});
  EXPECT_THAT(book->unstored(), IsEmpty());
  ASSERT_EQ(standing().size(), 1u) << "nobody has seen it yet";
  EXPECT_EQ(standing()[0].since, since);
  EXPECT_GT(standing()[0].cleared, since);
  look({lost("laser-x")});
  EXPECT_EQ(standing().size(), 2u) << "its return is another";
}

// Alarms that gather in memory are out of sight while the store is asked to take them.
TEST_F(AlarmBookTest, OneThatFlickersOnAFullDiskIsOneAlarm) {
  store->disk.full = true;
  look({lost("laser-x")});
  const CellTime since = book->unstored()[0].since;
  for (int i = 0; i < 6; ++i) {
    look(i % 3 == 2 ? Conditions{lost("laser-x")} : Conditions{});
    EXPECT_EQ(book->unstored()[0].cleared.utc_ns, 0) << "two looks without it are not its end";
  }
  EXPECT_EQ(heard.size(), 1u);
  for (int i = 0; i < AlarmBook::kLooksToClear; ++i) look({});
  EXPECT_NE(book->unstored()[0].cleared.utc_ns, 0);
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_NE(heard[1].cleared.utc_ns, 0);
  look({lost("laser-x")});
  ASSERT_EQ(heard.size(), 3u) << "its end was told: its return is another";
  store->disk.full = false;
  look({lost("laser-x")});
  auto all = standing();
  std::ranges::sort(all, {}, &AlarmRecord::since);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].since, since);
  EXPECT_EQ(all[0].cleared, heard[1].cleared);
  EXPECT_EQ(all[1].cleared.utc_ns, 0);
}

TEST_F(AlarmBookTest, TwoThatAreOverAtOnceOnAFullDiskAreTwo) {
  store->disk.full = true;
  done(book->note({AlarmLevel::warning, "queue.failed", "queue entry 3", "the door was open"}));
  done(book->note({AlarmLevel::warning, "queue.failed", "queue entry 3", "the beam was lost"}));
  EXPECT_EQ(book->unstored().size(), 2u);
  store->disk.full = false;
  look({});
  EXPECT_THAT(book->unstored(), IsEmpty());
  ASSERT_EQ(standing().size(), 2u);
  EXPECT_NE(standing()[0].message, standing()[1].message);
}

TEST_F(AlarmBookTest, TellsConsequencesAtOnceAndNumbersNowAndThen) {
  AlarmCondition old{AlarmLevel::warning, "channel.stale", "t01_degC", "t01_degC is 31 s old"};
  look({old});
  old.message = "t01_degC is 33 s old";
  look({old});
  EXPECT_EQ(standing()[0].message, "t01_degC is 31 s old");
  for (int i = 0; i < 5; ++i) look({old});
  EXPECT_EQ(standing()[0].message, "t01_degC is 33 s old");
  old.consequences = {"run 3 waits", "t02_degC is old"};
  look({old});
  ASSERT_EQ(standing().size(), 1u);
  EXPECT_EQ(standing()[0].consequences, old.consequences);
  EXPECT_EQ(heard.size(), 3u) << "begun, new numbers, consequences";
  open();
  look({old});
  EXPECT_EQ(standing()[0].message, "t01_degC is 33 s old");
  EXPECT_EQ(standing()[0].consequences, old.consequences) << "over a restart";
}

TEST_F(AlarmBookTest, AnAlarmThatThereIsNotCannotBeAcknowledged) {
  const auto none = done(book->acknowledge(AlarmId{77}, "ada"));
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().reason, "NO_SUCH_ALARM");
  EXPECT_THAT(heard, IsEmpty());
}

}  // namespace
}  // namespace driftwise::application
