#include "server/application/support/support_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "server/application/plumbing/run_on.h"
#include "server/core/records/state_text.h"
#include "server/core/text/clean_text.h"
#include "server/core/try.h"
#include "server/formats/cell_file/without_secrets.h"
#include "server/formats/text/tar_gz.h"

namespace driftwise::application {
namespace {

constexpr std::int64_t kEvents = 5000;
constexpr int kAlarms = 500;
constexpr std::size_t kMostMember = 3U << 20U;
constexpr std::size_t kMostSecretFile = 1U << 20U;

struct Parts {
  std::vector<formats::ArchiveMember> members;
  std::string cell_file;
  std::vector<std::string> secret_files;
  std::int64_t utc_s = 0;
};

// Contents of the files that hold secrets, line by line, as values to be found and removed. Files
// that cannot be read hold nothing that the daemon could have said.
void take_secret_lines(const std::filesystem::path& path, std::vector<std::string>& values) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed) ||
      std::filesystem::file_size(path, failed) > kMostSecretFile)
    return;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.size() >= 4 && !line.starts_with("-----")) values.push_back(line);
  }
}

// The end of a text that is too long is the newer part.
std::string newest(std::string text) {
  if (text.size() <= kMostMember) return text;
  return "[the beginning was left out]\n" + text.substr(text.size() - kMostMember);
}

Result<std::string> archived(Parts& parts) {
  auto secrets = formats::secrets_of_cell_file(parts.cell_file);
  for (const auto& path : parts.secret_files) take_secret_lines(path, secrets);
  parts.members.push_back(
      {"driftwise-support/cell.toml", formats::cell_file_without_secrets(parts.cell_file)});
  for (auto& member : parts.members)
    member.text = newest(formats::without_secrets(std::move(member.text), secrets));
  return formats::tar_gz(parts.members, parts.utc_s);
}

struct Recorded {
  std::vector<EventRecord> events;
  std::vector<AlarmRecord> alarms;
  std::vector<std::string> tables;
};

Result<Recorded> read_record(Store& store) {
  Recorded out;
  DRIFTWISE_TRY(const auto cursor, store.records().newest());
  const std::int64_t last = cursor.event;
  DRIFTWISE_TRY(out.events,
                store.events().events(EventId{std::max<std::int64_t>(0, last - kEvents)},
                                      static_cast<int>(kEvents)));
  DRIFTWISE_TRY(out.alarms, store.alarms().alarms(true, kAlarms));
  if (auto* upkeep = store.upkeep()) {
    if (auto tables = upkeep->tables()) out.tables = std::move(*tables);
  }
  return out;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + '\n';
  return text;
}

}  // namespace

SupportService::SupportService(Program program, Workbench& bench, StoreReader& reader,
                               const Overview& overview, asio::any_io_executor background)
    : program_(std::move(program)),
      bench_(bench),
      reader_(reader),
      overview_(overview),
      background_(std::move(background)) {}

std::string SupportService::versions() const {
  const auto status = overview_.status();
  std::string system;
  std::ifstream release("/etc/os-release"), kernel("/proc/sys/kernel/osrelease");
  for (std::string line; std::getline(release, line);)
    if (line.starts_with("PRETTY_NAME=")) system = line.substr(12);
  std::string version;
  std::getline(kernel, version);
  return fmt::format("driftwised {}\nschema {}\ncell file {}\nsystem {}\nkernel {}\n",
                     status.version, program_.schema_version, status.config_hash, system, version);
}

std::string SupportService::devices() const {
  std::string text;
  for (const auto& one : overview_.status().devices) {
    const auto& health = one.health;
    text += fmt::format(
        "{} ({}) at {}\n  link {}, identity '{}'\n  exchanges {}, errors {}, reconnects {}, last "
        "answer after {:.1f} ms\n",
        one.description.id, one.description.kind, one.description.address,
        health.link == LinkState::connected    ? "connected"
        : health.link == LinkState::connecting ? "connecting"
        : health.link == LinkState::failed     ? "failed"
                                               : "disconnected",
        health.identity, health.exchanges, health.errors, health.reconnects,
        1000 * health.last_latency_s);
    if (!health.last_error.empty()) text += "  last error: " + health.last_error + '\n';
    if (health.clock_offset)
      text += fmt::format("  its clock minus cell time {:.3f} s, set {} times\n",
                          seconds_from(*health.clock_offset), health.clock_jumps);
  }
  return text;
}

std::string SupportService::state() const {
  const auto status = overview_.status();
  std::string text = fmt::format("cell '{}' at {}, speed {:g}\n", status.name,
                                 to_iso8601(bench_.clock.utc(status.now.utc)), status.speed);
  text += status.run
              ? fmt::format("run {} '{}' {}: {} accepted, {} given up, of {} rows. {}\n",
                            status.run->run.id.value, status.run->run.name,
                            is_text(status.run->run.state), status.run->run.accepted,
                            status.run->run.given_up, status.run->run.rows, status.run->run.reason)
              : "no run is under way\n";
  if (status.serving) text += fmt::format("model {} serves\n", status.serving->value);
  text += fmt::format("longest pause of the daemon {:.3f} s\n", status.longest_pause_s);
  for (const auto& sentence : status.attention) text += "attention: " + sentence + '\n';
  text += "\nlatest values\n";
  for (const auto& value : status.values)
    text += fmt::format("{} = {:.9g}, {:.1f} s old{}, by {}\n", value.channel.name(), value.value,
                        value.age_s, value.stale ? ", stale" : "", value.device);
  return text;
}

Awaitable<Result<std::string>> SupportService::make(Caller caller) {
  co_await bench_.events.written();
  DRIFTWISE_CO_TRY(auto record, co_await reader_.call(read_record));
  Parts parts;
  const auto& cell = overview_.description();
  parts.cell_file = cell.text;
  parts.secret_files = {
      cell.access.key, cell.watchdog.token_file,
      (std::filesystem::path(cell.database).parent_path() / "driftwised.token").string()};
  for (const auto& one : cell.receivers) {
    parts.secret_files.push_back(one.token_file);
    parts.secret_files.push_back(one.password_file);
  }
  parts.utc_s = bench_.clock.utc(bench_.clock.now().utc).ns / 1'000'000'000;
  std::string events, alarms;
  for (const auto& event : record.events)
    events +=
        fmt::format("{} {} {} {}: {}\n", event.id.value, to_iso8601(bench_.clock.utc(event.at.utc)),
                    event.who, event.what, clean_text(event.detail));
  for (const auto& alarm : record.alarms)
    alarms += fmt::format("{} {} {} {}, {}: {}\n", alarm.id.value,
                          to_iso8601(bench_.clock.utc(alarm.since)), to_string(alarm.state()),
                          alarm.kind, alarm.subject, clean_text(alarm.message));
  const auto add = [&parts](const char* name, std::string text) {
    parts.members.push_back({std::string("driftwise-support/") + name, std::move(text)});
  };
  add("README.txt",
      "Made by 'driftwise support bundle'. Without tokens, passwords and private keys; addresses "
      "of "
      "receivers are cut to their host. Times are UTC.\n");
  add("versions.txt", versions());
  add("devices.txt", devices());
  add("state.txt", state());
  add("events.txt", std::move(events));
  add("alarms.txt", std::move(alarms));
  add("tables.txt", fmt::format("schema {}\n", program_.schema_version) + joined(record.tables));
  add("log.txt", program_.log_tail ? joined(program_.log_tail())
                                   : std::string("the daemon keeps no log of its own\n"));
  DRIFTWISE_CO_TRY(auto bytes, co_await run_on(background_, archived, std::move(parts)));
  bench_.events.record(
      caller, "support.bundle",
      fmt::format("{} made a support bundle of {} bytes", caller.name, bytes.size()));
  co_return bytes;
}

}  // namespace driftwise::application
