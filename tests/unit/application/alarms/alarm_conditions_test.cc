// Channels that are late, and those that nobody reads while a run is under way.
#include "server/application/alarms/alarm_conditions.h"

#include <gmock/gmock.h>

namespace driftwise::application {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> kinds_of(const CellStatus& status) {
  std::vector<std::string> kinds;
  for (const auto& one : alarm_conditions(status)) kinds.push_back(one.kind);
  return kinds;
}

// Two robots: the controller of the upper one is read every 0.2 s, and was read last an hour ago.
CellStatus status_of(DeviceRole role) {
  CellStatus status;
  DeviceStatus device;
  device.description.id = "upper";
  device.description.period_s = 0.2;
  device.description.settings = settings_for(role);
  device.health.link = LinkState::connected;
  status.devices = {device};
  status.values = {{.channel = {"mn.q1", "mm"},
                    .value = 1,
                    .at = CellTime{1},
                    .age_s = 3600,
                    .stale = true,
                    .device = "upper"}};
  return status;
}

TEST(StaleChannels, OfTheControllerOfAnotherRobotThanTheRunMeasuresAreNoAlarm) {
  auto status = status_of(DeviceRole::motion);
  EXPECT_THAT(kinds_of(status), ElementsAre("channel.stale"));
  status.run.emplace();  // it measures the lower robot
  EXPECT_THAT(kinds_of(status), IsEmpty());
}

TEST(StaleChannels, OfTheThermometersAreAnAlarmWhileARunIsUnderWay) {
  auto status = status_of(DeviceRole::temperature);
  status.run.emplace();
  EXPECT_THAT(kinds_of(status), ElementsAre("channel.stale"));
}

TEST(ForcedShutdown, IsAnAlarmAsLongAsTheSupplySaysSo) {
  auto status = status_of(DeviceRole::supply);
  auto& said = status.values.front();
  said.channel = {"ups_forced", "1"};
  said.value = 0;
  said.stale = false;
  EXPECT_THAT(kinds_of(status), IsEmpty());
  said.value = 1;
  EXPECT_THAT(kinds_of(status), ElementsAre("supply.forced"));
}

}  // namespace
}  // namespace driftwise::application
