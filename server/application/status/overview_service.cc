#include "server/application/status/overview_service.h"

#include <fmt/format.h>

#include "server/application/commissioning/device_checks.h"
#include "server/application/motion/loading.h"

namespace driftwise::application {

OverviewService::OverviewService(Program program, Sources sources)
    : program_(std::move(program)),
      description_(sources.bench.description),
      clock_(sources.bench.clock),
      bench_(sources.bench.devices),
      recorder_(sources.bench.recorder),
      writer_(sources.bench.writer),
      stops_(sources.bench.stops),
      engine_(sources.engine),
      leases_(sources.leases),
      manual_(sources.manual),
      serving_(sources.serving),
      checks_(sources.checks),
      configuration_(sources.configuration),
      upkeep_(sources.upkeep),
      pauses_(sources.pauses),
      notify_(sources.notify) {}

std::optional<double> stale_after_s(const DeviceDescription* device, std::string_view device_id) {
  if (device) return device->max_age_s;
  if (device_id == kOperatorDevice) return std::nullopt;
  return DeviceDescription{}.max_age_s;
}

CellStatus OverviewService::status() const {
  CellStatus status;
  status.name = description_.name;
  status.version = program_.version;
  status.config_hash = description_.hash;
  status.web_address = program_.web_address;
  status.now = clock_.now();
  status.utc_offset = Nanoseconds(clock_.utc(status.now.utc).ns - status.now.utc.utc_ns);
  status.speed = clock_.speed();
  status.devices = bench_.status();
  for (const auto& latest : recorder_.history().latest()) {
    auto channel = parse_robot_channel(latest.channel);
    if (!channel) continue;
    const auto* device = description_.find_device(latest.device);
    const bool never = latest.at.utc_ns == 0;
    const double age_s = never ? 0 : seconds_from(status.now.utc - latest.at);
    const auto limit_s = stale_after_s(device, latest.device);
    status.values.push_back({*channel, latest.value, latest.at, age_s,
                             never || (limit_s && age_s > *limit_s), latest.device});
  }
  if (engine_.busy()) status.run = engine_.progress();
  status.lease = leases_.present(status.now.utc);
  status.serving = serving_.model();
  status.database = upkeep_.health();
  status.attention = attention();
  status.longest_pause_s = pauses_.longest_s();
  status.recent_pause_s = pauses_.recent_s();
  status.pending_stops = stops_.records();
  return status;
}

std::vector<std::string> OverviewService::attention() const {
  std::vector<std::string> sentences;
  if (const auto& access = description_.access; !access.plain_target_line.empty())
    sentences.push_back(
        fmt::format("the text line at {} is not encrypted: whoever is on the network of {} can "
                    "read targets and "
                    "pretend to be a listed address",
                    access.plain_target_line, access.plain_interface));
  for (auto& stop : stops_.unconfirmed()) sentences.push_back(std::move(stop.sentence));
  for (const auto& id : bench_.lost())
    sentences.push_back(fmt::format("device {} does not answer", id));
  if (const auto* run = engine_.record(); run && run->state == RunState::waiting)
    sentences.push_back(fmt::format("run {} waits: {}", run->id.value, run->reason));
  if (auto question = configuration_.question(); !question.empty())
    sentences.push_back(std::move(question));
  if (!manual_.waits().empty()) sentences.push_back(manual_.waits());
  if (!manual_.motion_trouble().empty()) sentences.push_back(manual_.motion_trouble());
  if (!manual_.datum_trouble().empty()) sentences.push_back(manual_.datum_trouble());
  if (serving_.refused()) sentences.push_back(serving_.refused()->message);
  if (!serving_.trouble().empty()) sentences.push_back(serving_.trouble());
  if (!checks_.trouble().empty()) sentences.push_back(checks_.trouble());
  for (auto& overdue : overdue_certificates(description_, clock_.utc(clock_.now().utc).ns))
    sentences.push_back(std::move(overdue.sentence));
  for (const auto& condition : upkeep_.conditions()) sentences.push_back(condition.message);
  for (const auto& condition : notify_.conditions()) sentences.push_back(condition.message);
  if (writer_.is_dropping())
    sentences.push_back(fmt::format("slow readings are dropped, {} so far: nothing can be written",
                                    writer_.dropped()));
  return sentences;
}

}  // namespace driftwise::application
