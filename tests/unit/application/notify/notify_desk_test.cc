// Alarms on their way out: each once, repeated, over; through refusals, restarts and shelves.

#include "server/application/notify/notify_desk.h"

#include <gmock/gmock.h>

#include "server/access/access_witness.h"
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
  std::set<std::string> greylisted;  // addresses
  std::vector<std::string> reached;  // addresses, one for each mail
  std::size_t messages = 0;
};

class OutsideNotifier final : public Notifier {
 public:
  explicit OutsideNotifier(Outside& outside) : outside_(outside) {}
  Result<Delivery> tell(const ReceiverDescription& receiver, const Notice& notice) override {
    if (outside_.refusing.contains(receiver.name))
      return fail(ErrorCode::unavailable, "NOT_DELIVERED", "HTTP 500");
    std::vector<Delivery::Refused> refused;
    for (const auto& address : receiver.to)
      if (outside_.greylisted.contains(address))
        refused.push_back({address, "450 4.2.0 greylisted", true});
    if (!refused.empty() && refused.size() == receiver.to.size())
      return fail(ErrorCode::unavailable, "NOT_DELIVERED", "450 4.2.0 greylisted");
    for (const auto& address : receiver.to)
      if (!outside_.greylisted.contains(address)) outside_.reached.push_back(address);
    ++outside_.messages;
    for (const auto& news : notice.news) {
      const char* kind = news.kind == NewsKind::firing   ? " firing "
                         : news.kind == NewsKind::repeat ? " again "
                                                         : " over ";
      outside_.told.push_back(receiver.name + kind + news.alarm.kind + " " + news.alarm.subject);
    }
    if (notice.test) outside_.told.push_back(receiver.name + " test");
    Delivery delivery("HTTP 200");
    delivery.refused = std::move(refused);
    return delivery;
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
  // A device was lost and came back, and both were told.
  CellInMemory& open_with_an_alarm_that_is_over() {
    auto& cell = open();
    cell.pass(30);
    world.scanner_away = true;
    cell.pass(120);
    world.scanner_away = false;
    cell.pass(120);
    return cell;
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

// Published limits are for hours: what was said about them is kept over a restart.
TEST_F(NotifyDeskTest, ALimitThatHoldsOverARestartIsNotToldAsOver) {
  limits.emplace_back().channel = "t01_degC";
  limits.back().above = 0.0;
  limits.back().for_s = 3600;
  auto& cell = open();
  cell.pass(3700);
  EXPECT_THAT(outside.told, ElementsAre("duty firing channel.limit t01_degC above 0"));
  ASSERT_TRUE(cell.await(cell->alarms.acknowledge(cell.ada, alarm_of("channel.limit"))));
  auto& again = reopen();
  again.pass(3700);
  EXPECT_THAT(outside.told, SizeIs(1)) << testing::PrintToString(outside.told);
  const auto alarms = again.await(again->alarms.list(true, 100));
  ASSERT_THAT(*alarms, SizeIs(1));
  EXPECT_EQ(alarms->front().acknowledged_by, "ada");
}

TEST_F(NotifyDeskTest, ADeviceThatIsAwayOverARestartIsNotToldAsOver) {
  auto& cell = open();
  cell.pass(30);
  world.scanner_away = true;
  cell.pass(120);
  EXPECT_THAT(told_of("firing device.lost"), SizeIs(1));
  world.axis_away = world.laser_away = world.support_away = true;
  auto& again = reopen();
  again.pass(300);
  EXPECT_THAT(told_of("over"), IsEmpty());
  EXPECT_THAT(told_of("firing device.lost scanner"), SizeIs(1));
  world.scanner_away = false;
  again.pass(120);
  EXPECT_THAT(told_of("over"), ElementsAre("duty over device.lost scanner"));
}

TEST_F(NotifyDeskTest, WhatIsDoneToAnAlarmThatIsOverIsNoNews) {
  auto& cell = open_with_an_alarm_that_is_over();
  const auto id = alarm_of("device.lost");
  EXPECT_THAT(outside.told, SizeIs(2)) << "begun and over";
  ASSERT_TRUE(cell.await(cell->alarms.shelve(cell.ada, id, 60, "the door is open")));
  cell.pass(120);  // it comes back by itself
  ASSERT_TRUE(cell.await(cell->alarms.acknowledge(cell.ada, id)));
  cell.pass(120);
  EXPECT_THAT(outside.told, SizeIs(2)) << testing::PrintToString(outside.told);
  auto& again = reopen();
  again.pass(30);
  ASSERT_TRUE(again.await(again->alarms.shelve(again.ada, id, 3600, "the door is open")));
  ASSERT_TRUE(again.await(again->alarms.unshelve(again.ada, id)));
  ASSERT_TRUE(again.await(again->alarms.acknowledge(again.ada, id)));
  again.pass(120);
  EXPECT_THAT(outside.told, SizeIs(2)) << testing::PrintToString(outside.told);
  const auto tellings = again.await(again->notifications.tellings(10));
  ASSERT_THAT(*tellings, SizeIs(1));
  EXPECT_EQ(tellings->front().count, 2) << "what the record says of it";
}

TEST_F(NotifyDeskTest, AnAlarmThatWasOverEightDaysAgoIsNoNewsWhenItIsAcknowledged) {
  auto& cell = open_with_an_alarm_that_is_over();
  begin = cell.now() + nanoseconds_from_s(8 * 86'400);
  auto& again = open();
  again.pass(60);
  outside.told.clear();
  ASSERT_TRUE(again.await(again->alarms.acknowledge(again.ada, alarm_of("device.lost"))));
  again.pass(120);
  EXPECT_THAT(outside.told, IsEmpty());
}

TEST_F(NotifyDeskTest, ARecipientWhoIsRefusedForNowGetsTheMailLaterAndNobodyElseTwice) {
  auto mail = receiver("mail");
  mail.to = {"ada@lab.example", "bob@lab.example"};
  auto& cell = open({mail, receiver("duty")});
  cell.pass(30);
  outside.greylisted = {"bob@lab.example"};
  world.scanner_away = true;
  cell.pass(50);
  EXPECT_THAT(outside.reached, ElementsAre("ada@lab.example"));
  const auto open = cell.await(cell->notifications.tellings(10));
  ASSERT_FALSE(open->empty());
  EXPECT_THAT(told_of("notify.failed"), IsEmpty()) << "not for a minute";
  cell.pass(120);
  EXPECT_THAT(told_of("duty firing notify.failed"),
              ElementsAre("duty firing notify.failed mail bob@lab.example"));
  const auto tellings = cell.await(cell->notifications.tellings(10));
  EXPECT_THAT(*tellings, testing::Contains(testing::Field(
                             &TellingRecord::error, HasSubstr("bob@lab.example: 450 4.2.0"))));
  outside.greylisted.clear();
  outside.reached.clear();
  cell.pass(320);
  EXPECT_THAT(outside.reached, testing::Contains("bob@lab.example").Times(testing::Ge(2)))
      << "the lost device, and what followed";
  EXPECT_THAT(told_of("duty over notify.failed mail bob@lab.example"), SizeIs(1));
}

TEST_F(NotifyDeskTest, AReceiverThatIsWidenedIsNotToldOfWhatIsOverAndSeen) {
  auto narrow = receiver("duty");
  narrow.kinds = {"run.*"};
  auto& cell = open({narrow});
  cell.pass(30);
  world.scanner_away = true;
  cell.pass(120);
  world.scanner_away = false;
  cell.pass(120);
  ASSERT_TRUE(cell.await(cell->alarms.acknowledge(cell.ada, alarm_of("device.lost"))));
  reopen().pass(120);
  EXPECT_THAT(outside.told, IsEmpty());
}

// One client with a token that has ended tries on and on.
TEST_F(NotifyDeskTest, AClientThatKeepsTryingIsOneAlarmThatSaysWhoAndEndsWithItsSilence) {
  using access::AccessNote;
  auto& cell = open();
  for (int i = 0; i < 20; ++i) {
    cell.cell().access_witness().note({AccessNote::Kind::locked, "poller", "ipv4:10.0.0.2:4711",
                                       "a wrong token, number " + std::to_string(i + 5) +
                                           " in a row: nothing from there is looked at for 60 s"});
    cell.pass(75);
  }
  EXPECT_THAT(outside.told, ElementsAre("duty firing access.wrong_tries ipv4:10.0.0.2"));
  const auto alarms = cell.await(cell->alarms.list(true, 100));
  ASSERT_THAT(*alarms, SizeIs(1));
  EXPECT_THAT(alarms->front().message,
              testing::AllOf(HasSubstr("ipv4:10.0.0.2, which calls itself 'poller',"),
                             HasSubstr("driftwise token create")));
  cell.pass(3500);
  EXPECT_THAT(told_of("over"), IsEmpty());
  cell.pass(200);
  EXPECT_THAT(told_of("over"), SizeIs(1));
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
