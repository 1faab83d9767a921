// Alarms on their way out: each once, repeated, over; through refusals, restarts and shelves.

#include "server/application/notify/notify_desk.h"

#include <gmock/gmock.h>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// What stands outside the machine; it outlives the cell.
struct Outside {
  std::vector<std::string> told;  // "duty firing device.lost laser"
  std::set<std::string> refusing;
  std::size_t messages = 0;
};

class OutsideNotifier final : public Notifier {
 public:
  explicit OutsideNotifier(Outside& outside) : outside_(outside) {}
  Result<std::string> tell(const ReceiverDescription& receiver, const Notice& notice) override {
    if (outside_.refusing.contains(receiver.name))
      return fail(ErrorCode::unavailable, "NOT_DELIVERED", "HTTP 500");
    ++outside_.messages;
    for (const auto& news : notice.news) {
      const char* kind = news.kind == NewsKind::firing   ? " firing "
                         : news.kind == NewsKind::repeat ? " again "
                                                         : " over ";
      outside_.told.push_back(receiver.name + kind + news.alarm.kind + " " + news.alarm.subject);
    }
    if (notice.test) outside_.told.push_back(receiver.name + " test");
    return std::string("HTTP 200");
  }
  Result<std::string> report(const WatchdogRules&, const LifeSign&) override {
    return std::string("HTTP 204");
  }
  void shut_down() override {}

 private:
  Outside& outside_;
};

class NotifyDeskTest : public testing::Test {
 protected:
  static ReceiverDescription receiver(const std::string& name) {
    ReceiverDescription out;
    out.name = name;
    return out;
  }
  CellInMemory& open(std::vector<ReceiverDescription> receivers = {receiver("duty")}) {
    cell_.reset();
    auto description = small_cell(folder / "cell.sqlite");
    description.receivers = std::move(receivers);
    description.channel_alarms = limits;
    CellInMemory::Further further;
    further.begin = begin;
    further.notifier = std::make_unique<OutsideNotifier>(outside);
    return cell_.emplace(world, description, kSqlite, std::move(further));
  }
  // As after a kill: nothing of the old cell is asked any more.
  CellInMemory& reopen() {
    begin = cell_->now() + nanoseconds_from_s(1);
    return open();
  }
  AlarmId alarm_of(const std::string& kind) {
    const auto alarms = cell_->await((*cell_)->alarms.list(false, 100));
    for (const auto& one : *alarms)
      if (one.kind == kind) return one.id;
    return {};
  }
  std::vector<std::string> told_of(const std::string& what) const {
    std::vector<std::string> out;
    for (const auto& line : outside.told)
      if (line.find(what) != std::string::npos) out.push_back(line);
    return out;
  }

  Folder folder;
  SmallWorld world;
  Outside outside;
  CellTime begin = kWorldBegin;
  std::vector<ChannelAlarmDescription> limits;
  std::optional<CellInMemory> cell_;
};

TEST_F(NotifyDeskTest, AnIncidentIsToldOnceRepeatedAndItsEndIsTold) {
  auto& cell = open();
  cell.pass(30);
  EXPECT_THAT(outside.told, IsEmpty());
  world.scanner_away = true;
  cell.pass(120);  // what the device measures grows old meanwhile: a consequence
  ASSERT_THAT(outside.told, SizeIs(1)) << testing::PrintToString(outside.told);
  EXPECT_THAT(outside.told[0], HasSubstr("duty firing device.lost"));
  cell.pass(4 * 3600);
  EXPECT_THAT(told_of("again"), SizeIs(1));
  const auto id = alarm_of("device.lost");
  ASSERT_TRUE(cell.await(cell->alarms.acknowledge(cell.ada, id)));
  cell.pass(9 * 3600);
  EXPECT_THAT(told_of("again"), SizeIs(1));
  world.scanner_away = false;
  cell.pass(120);
  EXPECT_THAT(told_of("over"), SizeIs(1));
  EXPECT_THAT(outside.told, SizeIs(3));
}

TEST_F(NotifyDeskTest, WhatWasNotDeliveredIsToldAfterTheRestart) {
  outside.refusing = {"duty"};
  auto& cell = open();
  world.scanner_away = true;
  cell.pass(60);
  EXPECT_THAT(outside.told, IsEmpty());
  outside.refusing.clear();
  auto& again = reopen();
  again.pass(30);
  EXPECT_THAT(told_of("firing device.lost"), SizeIs(1));
  auto& third = reopen();  // it knows that it was told
  third.pass(300);
  EXPECT_THAT(told_of("firing device.lost"), SizeIs(1));
}

TEST_F(NotifyDeskTest, AReceiverThatTakesNothingIsAnAlarmOnTheOthers) {
  auto& cell = open({receiver("duty"), receiver("mail")});
  outside.refusing = {"mail"};
  world.scanner_away = true;
  cell.pass(300);
  EXPECT_THAT(told_of("duty firing device.lost"), SizeIs(1));
  EXPECT_THAT(told_of("duty firing notify.failed mail"), SizeIs(1));
  EXPECT_THAT(told_of("mail firing"), IsEmpty());
  const auto status = cell->notifications.receivers();
  ASSERT_THAT(status, SizeIs(2));
  EXPECT_NE(status[1].failing_since.utc_ns, 0);
  EXPECT_EQ(status[1].answer, "HTTP 500");
  EXPECT_EQ(status[1].waiting, 1);
  EXPECT_THAT(cell.status().attention, testing::Contains(HasSubstr("mail (mail by ")));
  outside.refusing.clear();
  cell.pass(600);
  EXPECT_THAT(told_of("mail firing device.lost"), SizeIs(1));
  EXPECT_THAT(told_of("duty over notify.failed mail"), SizeIs(1));
  EXPECT_THAT(told_of("mail firing notify.failed"), IsEmpty());
}

TEST_F(NotifyDeskTest, WhatBeginsTogetherIsOneMessage) {
  for (const char* channel : {"t01_degC", "t02_degC"}) {
    limits.emplace_back().channel = channel;
    limits.back().above = 0.0;
  }
  open().pass(120);
  EXPECT_THAT(told_of("firing channel.limit"), SizeIs(2));
  EXPECT_EQ(outside.messages, 1U);
}

TEST_F(NotifyDeskTest, AShelvedAlarmIsToldWhenItsTimeIsOver) {
  limits.emplace_back().channel = "t01_degC";
  limits.back().above = 0.0;
  auto patient = receiver("duty");
  patient.group_s = 600;
  auto& cell = open({patient});
  cell.pass(60);
  const auto id = alarm_of("channel.limit");
  ASSERT_NE(id.value, 0);
  const auto none = cell.await(cell->alarms.shelve(cell.ada, id, 3600, ""));
  EXPECT_EQ(none.error().reason, "BAD_SHELF");
  EXPECT_EQ(cell.await(cell->alarms.shelve(cell.ada, id, 90'000, "why")).error().reason,
            "BAD_SHELF");
  const auto shelved = cell.await(cell->alarms.shelve(cell.ada, id, 3600, "the door is open"));
  ASSERT_TRUE(shelved) << shelved.error().message;
  EXPECT_EQ(shelved->state(), AlarmState::shelved);
  cell.pass(3400);
  EXPECT_THAT(outside.told, IsEmpty());
  cell.pass(400);
  EXPECT_THAT(outside.told, ElementsAre("duty firing channel.limit t01_degC above 0"));
  EXPECT_THAT(cell.events_named("alarm.shelved"), SizeIs(1));
}

TEST_F(NotifyDeskTest, ATestIsSentToTheReceiverThatIsNamed) {
  auto& cell = open();
  const auto said = cell.await(cell->notifications.test(cell.ada, "duty"));
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(*said, "HTTP 200");
  EXPECT_THAT(outside.told, ElementsAre("duty test"));
  const auto none = cell.await(cell->notifications.test(cell.ada, "dut"));
  EXPECT_EQ(none.error().reason, "NO_SUCH_RECEIVER");
  EXPECT_THAT(none.error().message, HasSubstr("the cell file has duty"));
}

}  // namespace
}  // namespace driftwise::tests
