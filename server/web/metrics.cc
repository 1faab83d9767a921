#include "server/web/metrics.h"

#include <fmt/format.h>

#include <iterator>

#include "server/core/text/clean_text.h"

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
    if (labels.empty())
      fmt::format_to(std::back_inserter(out_), "{} {}\n", name, value);
    else
      fmt::format_to(std::back_inserter(out_), "{}{{{}}} {}\n", name, labels, value);
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

void values(Text& text, const application::CellStatus& status) {
  text.family("driftwise_channel", "gauge", "Latest value of a channel, in the unit of its label.");
  for (const auto& value : status.values)
    if (!is_missing(value.value))
      text.sample("driftwise_channel",
                  fmt::format("channel=\"{}\",unit=\"{}\"", label(value.channel.symbol),
                              label(value.channel.unit)),
                  value.value);
  text.family("driftwise_channel_age_seconds", "gauge",
              "Cell seconds since the channel was measured.");
  for (const auto& value : status.values)
    text.sample("driftwise_channel_age_seconds",
                fmt::format("channel=\"{}\"", label(value.channel.symbol)), value.age_s);
}

void run(Text& text, const application::RunProgress& progress) {
  const std::string id = fmt::format("run=\"{}\"", progress.run.id.value);
  text.family("driftwise_run_state", "gauge", "1 for the state the run is in.");
  text.sample("driftwise_run_state",
              fmt::format("{},state=\"{}\"", id, to_string(progress.run.state)), 1);
  text.family("driftwise_run_rows", "gauge", "Rows of the trajectory.");
  text.sample("driftwise_run_rows", id, static_cast<double>(progress.run.rows));
  text.family("driftwise_run_points_accepted", "gauge", "Points on disk.");
  text.sample("driftwise_run_points_accepted", id, static_cast<double>(progress.run.accepted));
  text.family("driftwise_run_points_given_up", "gauge",
              "Rows that failed the gate within all budgets.");
  text.sample("driftwise_run_points_given_up", id, static_cast<double>(progress.run.given_up));
  text.family("driftwise_run_lag_max_seconds", "gauge", "Largest lag, cell seconds.");
  text.sample("driftwise_run_lag_max_seconds", id, progress.run.max_lag_s);
}

}  // namespace

std::string metrics_text(const application::CellStatus& status) {
  Text text;
  text.family("driftwise_info", "gauge", "Version and cell.");
  text.sample("driftwise_info",
              fmt::format("version=\"{}\",cell=\"{}\"", label(status.version), label(status.name)),
              1);
  text.family("driftwise_attention", "gauge", "Sentences that ask for a person.");
  text.sample("driftwise_attention", "", static_cast<double>(status.attention.size()));
  text.family("driftwise_executor_longest_pause_seconds", "gauge",
              "Longest time since the start in which the daemon answered nobody.");
  text.sample("driftwise_executor_longest_pause_seconds", "", status.longest_pause_s);
  text.family("driftwise_executor_recent_pause_seconds", "gauge",
              "The same of the last minute; an alarm from 1 on.");
  text.sample("driftwise_executor_recent_pause_seconds", "", status.recent_pause_s);
  devices(text, status);
  values(text, status);
  if (status.run) run(text, *status.run);
  return text.take();
}

}  // namespace driftwise::web
