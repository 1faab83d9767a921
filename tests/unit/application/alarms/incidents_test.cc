// One cause, one alarm: what follows stands under it, and comes out when it cannot be explained any
// more.

#include "server/application/alarms/incidents.h"

#include <gmock/gmock.h>

namespace driftwise::application {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using Conditions = std::vector<AlarmCondition>;

AlarmCondition lost_device(const std::string& id, const std::string& address) {
  return {.level = AlarmLevel::failed,
          .kind = "device.lost",
          .subject = id,
          .message = id + " does not answer",
          .address = address};
}
AlarmCondition stale_channel(const std::string& channel, const std::string& device) {
  return {.kind = "channel.stale",
          .subject = channel,
          .message = channel + " is old",
          .device = device};
}
AlarmCondition waiting_run(const std::string& why) {
  return {
      .kind = "run.waiting", .subject = "run 3", .message = "run 3 waits: " + why, .detail = why};
}

class IncidentsTest : public testing::Test {
 protected:
  Conditions look(const Conditions& conditions, double after_s = 2) {
    now_ = now_ + nanoseconds_from_s(after_s);
    return incidents_.group(conditions, now_);
  }
  void restart() { incidents_ = {}; }
  void stand(const std::string& kind, const std::string& subject) {
    incidents_.stand(kind, subject, CellTime{1'000}, now_);
  }
  static std::vector<std::string> subjects(const Conditions& alarms) {
    std::vector<std::string> out;
    for (const auto& alarm : alarms)
      if (!alarm.settling) out.push_back(alarm.subject);
    return out;
  }

 private:
  Incidents incidents_;
  CellTime now_{1'000'000'000'000};
};

TEST_F(IncidentsTest, ALostDeviceIsOneAlarmWithAllThatFollows) {
  const auto scanner = lost_device("scanner", "127.0.0.1:5001");
  EXPECT_THAT(
      subjects(look({scanner, waiting_run("device 'scanner' at 127.0.0.1:5001: no answer")})),
      ElementsAre("scanner"));
  const auto alarms =
      look({scanner, stale_channel("t01_degC", "scanner"), stale_channel("t02_degC", "scanner"),
            waiting_run("device 'scanner' at 127.0.0.1:5001: no answer")},
           40);
  ASSERT_THAT(subjects(alarms), ElementsAre("scanner"));
  EXPECT_THAT(alarms[0].consequences,
              ElementsAre("run 3 waits: device 'scanner' at 127.0.0.1:5001: no answer",
                          "t01_degC is old", "t02_degC is old"));
}

// Once it is under another one, it would be told as over while it holds.
TEST_F(IncidentsTest, WhatStandsAsAnAlarmBecomesNoConsequence) {
  const auto axis = lost_device("axis", "10.0.0.7:5000"),
             scanner = lost_device("scanner", "10.0.0.7:5002");
  const auto stale = stale_channel("t01_degC", "scanner");
  look({stale});
  EXPECT_THAT(subjects(look({stale}, 31)), ElementsAre("t01_degC"));
  EXPECT_THAT(subjects(look({scanner, stale}, 5)), ElementsAre("t01_degC", "scanner"));
  // Over a restart, which finds the axis first.
  restart();
  stand("device.lost", "scanner");
  EXPECT_THAT(subjects(look({axis})), ElementsAre("axis"));
  for (int i = 0; i < 30; ++i) stand("device.lost", "scanner"), look({axis});
  EXPECT_THAT(subjects(look({axis, scanner})), ElementsAre("scanner", "axis"));
}

TEST_F(IncidentsTest, OfDevicesBehindOneAddressTheFirstThatFailedIsTheAlarm) {
  const auto laser = lost_device("laser-x", "10.0.0.7:5001"),
             scanner = lost_device("scanner", "10.0.0.7:5002"),
             axis = lost_device("axis", "10.0.0.9:5000");
  look({scanner});
  const auto alarms = look({axis, laser, scanner});
  ASSERT_THAT(subjects(alarms), ElementsAre("scanner", "axis")) << "the other computer by itself";
  EXPECT_THAT(alarms[0].consequences, ElementsAre("laser-x does not answer"));
}

TEST_F(IncidentsTest, ADeviceThatFailsMuchLaterHasItsOwnCause) {
  const auto laser = lost_device("laser-x", "10.0.0.7:5001"),
             scanner = lost_device("scanner", "10.0.0.7:5002");
  look({scanner});
  for (int i = 0; i < 30; ++i) look({scanner});
  EXPECT_THAT(subjects(look({laser, scanner})), ElementsAre("scanner", "laser-x"));
}

TEST_F(IncidentsTest, AConsequenceThatOutlastsItsCauseIsAnAlarmOfItsOwn) {
  const auto run = waiting_run("laser-x does not answer");
  look({lost_device("laser-x", "10.0.0.7:1"), run});
  EXPECT_THAT(look({run}), IsEmpty()) << "the run looks at its devices first";
  EXPECT_THAT(subjects(look({run}, 31)), ElementsAre("run 3"));
  EXPECT_THAT(subjects(look({lost_device("laser-x", "10.0.0.7:1"), run})),
              ElementsAre("run 3", "laser-x"))
      << "it stays one";
}

TEST_F(IncidentsTest, TheSettleTimeOfAHoldAfterItsDeviceIsBackIsNoFurtherIncident) {
  const auto scanner = lost_device("scanner", "10.0.0.7:1");
  const auto stale = stale_channel("t04_degC", "scanner");
  auto run = waiting_run("t04_degC has no fresh value (hold room)");
  const auto alarms = look({scanner, stale, run});
  ASSERT_THAT(subjects(alarms), ElementsAre("scanner"));
  EXPECT_THAT(alarms[0].consequences, ElementsAre(stale.message, run.message));
  run.is_ending = true;  // the value is back, and within its limits for 0 of 120 s
  for (int i = 0; i < 5; ++i) EXPECT_THAT(look({run}, 25), IsEmpty());
  run.is_ending = false;
  EXPECT_THAT(subjects(look({run}, 31)), ElementsAre("run 3")) << "beyond its limits again";
}

TEST_F(IncidentsTest, ARunThatNothingCausedIsNoLessAnAlarmWhileItsHoldSettles) {
  auto run = waiting_run("t04_degC is 21.1, limit 21 (hold room)");
  look({run});
  EXPECT_THAT(subjects(look({run}, 31)), ElementsAre("run 3"));
  run.is_ending = true;
  EXPECT_THAT(subjects(look({run}, 60)), ElementsAre("run 3"));
}

TEST_F(IncidentsTest, ARunThatWaitsForRoomOnTheDiskIsThatAlarmFromTheFirstMoment) {
  const auto run = waiting_run("database cell.sqlite: COMMIT: database or disk is full");
  AlarmCondition unwritten{.level = AlarmLevel::failed,
                           .kind = "record.unwritten",
                           .subject = "database",
                           .message = "the record takes nothing",
                           .settling = true};
  look({run, unwritten});
  EXPECT_THAT(subjects(look({run, unwritten}, 50)), IsEmpty());
  unwritten.settling = false;
  const auto alarms = look({run, unwritten}, 10);
  ASSERT_THAT(subjects(alarms), ElementsAre("database"));
  EXPECT_THAT(alarms[0].consequences, ElementsAre(run.message));
}

TEST_F(IncidentsTest, WhatAnotherFaultCouldExplainIsAnAlarmOfItsOwn) {
  const Conditions both = {lost_device("laser-x", "10.0.0.7:1"), lost_device("axis", "10.0.0.9:1"),
                           waiting_run("laser-x and axis do not answer")};
  look(both);
  EXPECT_THAT(subjects(look(both, 30)), ElementsAre("laser-x", "axis", "run 3"));
}

TEST_F(IncidentsTest, ARunThatWaitsBeforeItsDeviceCountsAsLostIsNoAlarmOfItsOwn) {
  const auto run = waiting_run("device 'laser-x' at 10.0.0.7:1: no answer");
  EXPECT_THAT(subjects(look({run})), IsEmpty()) << "its device may be lost in a moment";
  const auto alarms = look({run, lost_device("laser-x", "10.0.0.7:1")}, 10);
  ASSERT_THAT(subjects(alarms), ElementsAre("laser-x"));
  EXPECT_THAT(alarms[0].consequences, ElementsAre(run.message));
}

TEST_F(IncidentsTest, ARunThatWaitsWithoutACauseIsAnAlarmAfterHalfAMinute) {
  const auto run = waiting_run("hang 2.305 N (235 g)");
  look({run});
  EXPECT_THAT(subjects(look({run}, 29)), IsEmpty());
  EXPECT_THAT(subjects(look({run}, 1)), ElementsAre("run 3"));
}

TEST_F(IncidentsTest, OneScannerThatLiesIsOneAlarm) {
  const auto lie = [](const std::string& channel, const std::string& device) {
    return AlarmCondition{.level = AlarmLevel::failed,
                          .kind = "reading.impossible",
                          .subject = channel,
                          .message = channel + " is impossible",
                          .device = device};
  };
  const auto alarms = look({lie("t01_degC", "scanner"), lie("t02_degC", "scanner"),
                            lie("x_mm", "laser-x"), stale_channel("t02_degC", "scanner")});
  ASSERT_THAT(subjects(alarms), ElementsAre("t01_degC", "x_mm"));
  EXPECT_THAT(alarms[0].consequences, ElementsAre("t02_degC is impossible", "t02_degC is old"));
}

TEST_F(IncidentsTest, WhatHasAnotherReasonIsNoConsequence) {
  const auto alarms =
      look({lost_device("laser-x", "10.0.0.7:1"), waiting_run("hang 2.305 N (235 g)"),
            stale_channel("t01_degC", "scanner"), waiting_run("laser-xy is away")});
  EXPECT_THAT(alarms[0].consequences, IsEmpty());
}

}  // namespace
}  // namespace driftwise::application
