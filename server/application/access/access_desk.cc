#include "server/application/access/access_desk.h"

#include <spdlog/spdlog.h>

#include <boost/asio/post.hpp>
#include <chrono>
#include <utility>

#include "server/access/certificate.h"
#include "server/access/door_address.h"
#include "server/access/revoked_certificates.h"
#include "server/access/wrong_tries.h"
#include "server/application/plumbing/run_on.h"

namespace driftwise::application {
namespace {

// Certificates end by UTC, whatever cell time is.
std::int64_t utc_now_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

// Doors that wait for their address: a cable, a switch or the network is not there.
void look_at_doors(const AccessDescription& doors, std::vector<AlarmCondition>& out) {
  const std::pair<const char*, const std::string&> all[] = {
      {"listen", doors.listen},
      {"http", doors.http},
      {"target_line", doors.target_line},
      {"plain_target_line", doors.plain_target_line}};
  for (const auto& [key, address] : all)
    if (access::is_absent(address))
      out.push_back({AlarmLevel::warning, "door.unreached", std::string("[access] ") + key,
                     "nobody reaches " + address +
                         ": this computer does not have that address now. Look at cable, switch "
                         "and network settings, or correct [access] " +
                         key + "; the door needs no restart"});
}

void look_at_files(const AccessDescription& files, std::vector<AlarmCondition>& out) {
  const auto facts = access::check_certificate(files.certificate, files.key, utc_now_s());
  if (!facts)
    out.push_back(
        {AlarmLevel::failed, "certificate.unusable", files.certificate, facts.error().message});
  else if (auto warning = access::expiry_warning(files.certificate, *facts, utc_now_s());
           !warning.empty())
    out.push_back({AlarmLevel::warning, "certificate.ends", files.certificate, std::move(warning)});
  if (files.revoked.empty()) return;
  const auto list = access::RevokedCertificates::check(files.revoked, files.authority, utc_now_s());
  if (!list)
    out.push_back({AlarmLevel::warning, "certificate.revocations", files.revoked,
                   list.error().message + "; the last good list is in force"});
}

std::vector<AlarmCondition> look_at(const AccessDescription& described,
                                    const std::function<std::vector<access::EndingProof>()>& ends) {
  std::vector<AlarmCondition> out;
  look_at_doors(described, out);
  if (described.tls()) look_at_files(described, out);
  if (ends)
    for (auto& proof : ends())
      out.push_back(
          {AlarmLevel::warning, "access.ends", std::move(proof.subject), std::move(proof.message)});
  return out;
}

}  // namespace

AccessDesk::AccessDesk(asio::any_io_executor executor, asio::any_io_executor texts,
                       const AccessDescription& description, Clock& clock, EventLog& events,
                       TaskGroup& tasks, std::function<void(AlarmCondition)> alarm)
    : executor_(executor),
      texts_(std::move(texts)),
      description_(description),
      clock_(clock),
      events_(events),
      tasks_(tasks),
      alarm_(std::move(alarm)),
      ended_(executor) {}

void AccessDesk::note(access::AccessNote what) {
  // At once, on the caller's thread: the record may wait for its disk. The authoriser bounds their
  // number.
  if (what.kind == access::AccessNote::Kind::wrong_try ||
      what.kind == access::AccessNote::Kind::locked)
    spdlog::warn("access: {} from {}: {}", what.who.empty() ? "somebody" : what.who,
                 access::source_of(what.from), what.detail);
  asio::post(executor_, [this, what = std::move(what)] { take(what); });
}

void AccessDesk::ask_for_ends(std::function<std::vector<access::EndingProof>()> ends) {
  ends_ = std::move(ends);
}

void AccessDesk::take(const access::AccessNote& what) {
  if (ending_) return;
  using Kind = access::AccessNote::Kind;
  const bool refused =
      what.kind == Kind::refused || what.kind == Kind::wrong_try || what.kind == Kind::locked;
  ActChange act;
  act.subject = what.act;
  if (refused) act.outcome = "refused: " + what.detail;
  events_.record({what.who, what.from, what.proof}, access::to_event(what.kind), what.detail, {},
                 std::move(act));
  if (what.kind == access::AccessNote::Kind::locked)
    alarm_({AlarmLevel::warning, "access.wrong_tries", access::source_of(what.from), what.detail});
}

void AccessDesk::start() {
  if (description_.configured) tasks_.spawn(watch());
}

void AccessDesk::shut_down() {
  ending_ = true;
  ended_.raise();
}

Awaitable<void> AccessDesk::watch() {
  while (!ending_) {
    conditions_ = co_await run_on(texts_, &look_at, description_, ends_);
    const auto pause = nanoseconds_from_s(kLook_s * clock_.speed());
    co_await sleep_unless(clock_, clock_.now().utc + pause, ended_);
  }
}

}  // namespace driftwise::application
