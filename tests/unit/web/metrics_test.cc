#include "server/web/metrics.h"

#include <gmock/gmock.h>

#include <fstream>
#include <regex>
#include <set>
#include <sstream>

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
      {.channel = {"t07", "degC"}, .value = 20.5, .at = {1}, .age_s = 2.0, .device = "scanner"});
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
  EXPECT_THAT(
      text,
      HasSubstr("driftwise_build_info{version=\"0.1.0\",cell=\"a \\\"quoted\\\" cell\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_device_up{device=\"laser-x\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_device_errors_total{device=\"laser-x\"} 3\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_temperature_celsius{channel=\"t07\"} 20.5\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_channel_age_seconds{channel=\"t07\"} 2\n"));
  // Never read: the rule for old channels holds.
  EXPECT_THAT(text, HasSubstr("driftwise_channel_age_seconds{channel=\"t08\"} +Inf\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_run_state{run=\"7\",state=\"running\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_run_points_accepted_total{run=\"7\"} 12\n"));
}

TEST(MetricsText, GivesEveryQuantityInItsBaseUnit) {
  auto status = status_with_one_of_each();
  status.values.push_back({.channel = {"x", "mm"}, .value = 1.5, .at = {}, .device = "laser-x"});
  status.values.push_back(
      {.channel = {"rx", "arcsec"}, .value = 180 * 3600, .at = {}, .device = "a"});
  status.values.push_back({.channel = {"p", "hPa"}, .value = 1013.25, .at = {}, .device = "b"});
  status.values.push_back({.channel = {"rh", "pct"}, .value = 45, .at = {}, .device = "b"});
  const std::string text = metrics_text(status);
  EXPECT_THAT(text, HasSubstr("driftwise_position_meters{channel=\"x\"} 0.0015\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_angle_radians{channel=\"rx\"} 3.14159"));
  EXPECT_THAT(text, HasSubstr("driftwise_pressure_pascals{channel=\"p\"} 101325\n"));
  EXPECT_THAT(text, HasSubstr("driftwise_quantity_ratio{channel=\"rh\"} 0.45\n"));
  EXPECT_THAT(text, HasSubstr("process_open_fds "));
}

// Every family is told once, and every counter, and nothing else, ends in _total.
TEST(MetricsText, KeepsPrometheusConventions) {
  std::istringstream text(metrics_text(status_with_one_of_each()));
  std::set<std::string> families;
  for (std::string hash, what, name, type; text >> hash;) {
    if (hash != "#") {
      std::getline(text, hash);
      continue;
    }
    text >> what >> name;
    if (what == "TYPE") {
      text >> type;
      EXPECT_TRUE(families.insert(name).second) << name;
      EXPECT_EQ(type == "counter", name.ends_with("_total")) << name;
    } else {
      std::getline(text, hash);
    }
  }
  EXPECT_GT(families.size(), 10U);
}

std::string text_of(const std::string& path) {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Monitoring, RulesAndDashboardAskOnlyForWhatIsTold) {
  auto status = status_with_one_of_each();
  for (const char* unit : {"mm", "arcsec", "N", "hPa", "pct", "V", "s"})
    status.values.push_back({.channel = {"c", unit}, .value = 1, .at = {}, .device = "d"});
  const std::string told = metrics_text(status);
  static const std::regex name(R"(\b(driftwise|process)_[a-z_]+\b)");
  for (const std::string file :
       {"/deploy/monitoring/rules.yml", "/deploy/monitoring/dashboard.json"}) {
    const std::string text = text_of(file);
    int asked = 0;
    for (std::sregex_iterator found(text.begin(), text.end(), name), end; found != end; ++found) {
      EXPECT_THAT(told, HasSubstr("# TYPE " + found->str() + " ")) << file;
      ++asked;
    }
    EXPECT_GT(asked, 5) << file;
  }
}

TEST(MetricsText, LeavesMissingValuesOut) {
  EXPECT_THAT(metrics_text(status_with_one_of_each()), Not(HasSubstr("celsius{channel=\"t08\"")));
}

}  // namespace
}  // namespace driftwise::web
