#include "server/web/metrics.h"

#include <gmock/gmock.h>

namespace driftwise::web {
namespace {

using testing::HasSubstr;
using testing::Not;

application::CellStatus status_with_one_of_each() {
  application::CellStatus status;
  status.name = "a \"quoted\" cell";
  status.version = "0.1.0";
  application::DeviceStatus device;
  device.description.id = "laser-x";
  device.health.link = LinkState::connected;
  device.health.errors = 3;
  status.devices.push_back(device);
  status.values.push_back(
      {.channel = {"t07", "degC"}, .value = 20.5, .at = {}, .age_s = 2.0, .device = "scanner"});
  status.values.push_back({.channel = {"t08", "degC"}, .at = {}, .device = "scanner"});
  application::RunProgress progress;
  progress.run.id = {7};
  progress.run.state = RunState::running;
  progress.run.rows = 1008;
  progress.run.accepted = 12;
  status.run = progress;
  return status;
}

TEST(MetricsText, NamesDevicesChannelsAndTheRun) {
  const std::string text = metrics_text(status_with_one_of_each());
  EXPECT_THAT(text,
              HasSubstr("driftwise_info{version=\"0.1.0\",cell=\"a \\\"quoted\\\" cell\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_device_up{device=\"laser-x\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_device_errors_total{device=\"laser-x\"} 3\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_channel{channel=\"t07\",unit=\"degC\"} 20.5\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_run_state{run=\"7\",state=\"running\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_run_points_accepted{run=\"7\"} 12\n"));
}

TEST(MetricsText, LeavesMissingValuesOut) {
  EXPECT_THAT(metrics_text(status_with_one_of_each()),
              Not(HasSubstr("driftwise_channel{channel=\"t08\"")));
}

}  // namespace
}  // namespace driftwise::web
