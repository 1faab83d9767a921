#include "server/web/metrics.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "server/core/text/clean_text.h"
#include "server/core/unit_conversion.h"

namespace driftwise::web {
namespace {

std::string label(std::string_view text) {
  std::string out;
  for (const char c : clean_line(text)) {
    if (c == '\\' || c == '"') out += '\\';
    out += c;
  }
  return out;
}

class Text {
 public:
  void family(std::string_view name, std::string_view type, std::string_view help) {
    fmt::format_to(std::back_inserter(out_), "# HELP {0} {2}\n# TYPE {0} {1}\n", name, type, help);
  }
  void sample(std::string_view name, std::string_view labels, double value) {
    const std::string number =
        std::isinf(value) ? (value > 0 ? "+Inf" : "-Inf") : fmt::format("{}", value);
    if (labels.empty())
      fmt::format_to(std::back_inserter(out_), "{} {}\n", name, number);
    else
      fmt::format_to(std::back_inserter(out_), "{}{{{}}} {}\n", name, labels, number);
  }
  std::string take() { return std::move(out_); }

 private:
  std::string out_;
};

void devices(Text& text, const application::CellStatus& status) {
  text.family("driftwise_device_up", "gauge", "1 while the device answers.");
  for (const auto& device : status.devices)
    text.sample("driftwise_device_up", fmt::format("device=\"{}\"", label(device.description.id)),
                device.health.link == LinkState::connected ? 1 : 0);
  text.family("driftwise_device_errors_total", "counter", "Exchanges that failed.");
  for (const auto& device : status.devices)
    text.sample("driftwise_device_errors_total",
                fmt::format("device=\"{}\"", label(device.description.id)),
                static_cast<double>(device.health.errors));
  text.family("driftwise_device_latency_seconds", "gauge", "Wall time of the last exchange.");
  for (const auto& device : status.devices)
    text.sample("driftwise_device_latency_seconds",
                fmt::format("device=\"{}\"", label(device.description.id)),
                device.health.last_latency_s);
}

// Prometheus' naming: one base unit per family, named by it.
struct QuantityFamily {
  std::string_view unit, name, help;
};
constexpr std::array kQuantities = {
    QuantityFamily{"m", "driftwise_position_meters", "Positions and lengths."},
    QuantityFamily{"rad", "driftwise_angle_radians", "Angles."},
    QuantityFamily{"degC", "driftwise_temperature_celsius", "Temperatures."},
    QuantityFamily{"N", "driftwise_force_newtons", "Forces."},
    QuantityFamily{"Pa", "driftwise_pressure_pascals", "Pressures."},
    QuantityFamily{"1", "driftwise_quantity_ratio", "Shares: humidity, light levels."},
    QuantityFamily{"V", "driftwise_signal_volts", "Voltages."},
    QuantityFamily{"s", "driftwise_channel_seconds", "Times."},
};

void values(Text& text, const application::CellStatus& status) {
  for (const auto& quantity : kQuantities) {
    bool begun = false;
    for (const auto& value : status.values) {
      const auto convert = unit_conversion(value.channel.unit, quantity.unit);
      if (is_missing(value.value) || !convert) continue;
      if (!std::exchange(begun, true)) text.family(quantity.name, "gauge", quantity.help);
      text.sample(quantity.name, fmt::format("channel=\"{}\"", label(value.channel.symbol)),
                  (*convert)(value.value));
    }
  }
  text.family("driftwise_channel_age_seconds", "gauge",
              "Cell seconds since the channel was measured; +Inf: never since the start.");
  for (const auto& value : status.values)
    text.sample("driftwise_channel_age_seconds",
                fmt::format("channel=\"{}\"", label(value.channel.symbol)),
                value.at.utc_ns == 0 ? std::numeric_limits<double>::infinity() : value.age_s);
}

void run(Text& text, const application::RunProgress& progress) {
  const std::string id = fmt::format("run=\"{}\"", progress.run.id.value);
  text.family("driftwise_run_state", "gauge", "1 for the state the run is in.");
  text.sample("driftwise_run_state",
              fmt::format("{},state=\"{}\"", id, to_string(progress.run.state)), 1);
  text.family("driftwise_run_rows", "gauge", "Rows of the trajectory.");
  text.sample("driftwise_run_rows", id, static_cast<double>(progress.run.rows));
  text.family("driftwise_run_points_accepted_total", "counter", "Points on disk.");
  text.sample("driftwise_run_points_accepted_total", id,
              static_cast<double>(progress.run.accepted));
  text.family("driftwise_run_points_given_up_total", "counter",
              "Rows that failed the gate within all budgets.");
  text.sample("driftwise_run_points_given_up_total", id,
              static_cast<double>(progress.run.given_up));
  text.family("driftwise_run_lag_max_seconds", "gauge", "Largest lag, cell seconds.");
  text.sample("driftwise_run_lag_max_seconds", id, progress.run.max_lag_s);
}

// The process itself, under the names that Prometheus' own clients give it. Without /proc: nothing.
void process(Text& text) {
  const double ticks_per_s = static_cast<double>(::sysconf(_SC_CLK_TCK));
  const double page_bytes = static_cast<double>(::sysconf(_SC_PAGESIZE));
  std::ifstream file("/proc/self/stat");
  std::string line;
  if (!std::getline(file, line)) return;
  // The second field is the name in brackets, which may hold blanks; the third follows it.
  std::istringstream fields(line.substr(line.rfind(')') + 1));
  std::vector<std::string> field{"pid", "name"};
  for (std::string one; fields >> one;) field.push_back(one);
  constexpr std::size_t kUserTicks = 13, kSystemTicks = 14, kResidentPages = 23;  // proc(5)
  if (field.size() <= kResidentPages) return;
  text.family("process_cpu_seconds_total", "counter", "Processor time, user and system.");
  text.sample("process_cpu_seconds_total", "",
              (std::stod(field[kUserTicks]) + std::stod(field[kSystemTicks])) / ticks_per_s);
  text.family("process_resident_memory_bytes", "gauge", "Memory in use.");
  text.sample("process_resident_memory_bytes", "", std::stod(field[kResidentPages]) * page_bytes);
  std::error_code failed;
  std::filesystem::directory_iterator descriptors("/proc/self/fd", failed);
  if (failed) return;
  text.family("process_open_fds", "gauge", "Open descriptors.");
  text.sample("process_open_fds", "",
              static_cast<double>(std::distance(begin(descriptors), end(descriptors))));
}

}  // namespace

std::string metrics_text(const application::CellStatus& status) {
  Text text;
  text.family("driftwise_build_info", "gauge", "Version and cell.");
  text.sample("driftwise_build_info",
              fmt::format("version=\"{}\",cell=\"{}\"", label(status.version), label(status.name)),
              1);
  text.family("driftwise_attention_sentences", "gauge", "Sentences that ask for a person.");
  text.sample("driftwise_attention_sentences", "", static_cast<double>(status.attention.size()));
  text.family("driftwise_executor_longest_pause_seconds", "gauge",
              "Longest time since the start in which the daemon answered nobody.");
  text.sample("driftwise_executor_longest_pause_seconds", "", status.longest_pause_s);
  text.family("driftwise_executor_recent_pause_seconds", "gauge",
              "The same of the last minute; an alarm from 1 on.");
  text.sample("driftwise_executor_recent_pause_seconds", "", status.recent_pause_s);
  devices(text, status);
  values(text, status);
  if (status.run) run(text, *status.run);
  process(text);
  return text.take();
}

}  // namespace driftwise::web
