#include "server/application/access/access_desk.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
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

// "ipv4:10.0.0.2, which calls itself 'poller',"
std::string shown_source(const std::string& source, const std::string& name) {
  return name.empty() ? source : fmt::format("{}, which calls itself '{}',", source, name);
}

}  // namespace

AccessDesk::Looked AccessDesk::look_at(
    const AccessDescription& described,
    const std::function<std::vector<access::EndingProof>()>& ends) {
  Looked out;
  look_at_doors(described, out.conditions);
  if (described.tls()) look_at_files(described, out.conditions);
  if (!ends) return out;
  for (auto& proof : ends()) {
    out.proofs.insert(proof.subject);
    if (!proof.message.empty())
      out.conditions.push_back(
          {AlarmLevel::warning, "access.ends", std::move(proof.subject), std::move(proof.message)});
  }
  return out;
}

AccessDesk::AccessDesk(asio::any_io_executor executor, asio::any_io_executor texts,
                       const AccessDescription& description, Clock& clock, EventLog& events,
                       TaskGroup& tasks)
    : executor_(executor),
      texts_(std::move(texts)),
      description_(description),
      clock_(clock),
      events_(events),
      tasks_(tasks),
      started_(clock.now().utc),
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
  if (what.kind == Kind::locked || what.kind == Kind::wrong_try) take_try(what);
}

bool AccessDesk::is_silent(const Trying& one) const {
  return seconds_from(clock_.now().utc - one.last) >= kSilent_s * std::max(1.0, clock_.speed());
}

void AccessDesk::take_try(const access::AccessNote& what) {
  std::erase_if(trying_, [this](const auto& entry) { return is_silent(entry.second); });
  std::string source = access::source_of(what.from);
  const bool is_locked = what.kind == access::AccessNote::Kind::locked;
  if (!trying_.contains(source) && trying_.size() >= kMostSources) source = "further addresses";
  if (!is_locked && !trying_.contains(source)) return;  // a few wrong ones are a mistake
  Trying& one = trying_[source];
  if (!what.who.empty()) one.name = what.who;
  if (is_locked) one.detail = what.detail;
  one.last = clock_.now().utc;
}

std::vector<AlarmCondition> AccessDesk::conditions() const {
  auto out = looked_.conditions;
  for (const auto& [source, one] : trying_)
    if (!is_silent(one))
      out.push_back(
          {AlarmLevel::warning, "access.wrong_tries", source,
           fmt::format("{} keeps sending {}. Look for the client there whose token has ended or "
                       "was revoked ('driftwise token list'), give it another one ('driftwise "
                       "token create') or stop it; this is over {:g} min after its last try",
                       shown_source(source, one.name), one.detail, kSilent_s / 60)});
  return out;
}

// A certificate that is not shown again is forgotten a week after its end, 30 days after the first
// warning, as without a restart.
bool AccessDesk::has_judged(const std::string& kind, const std::string& subject) const {
  constexpr double kForgotten_s = (access::kExpiryWarningDays + 7) * 86'400.0;
  const double up_s = seconds_from(clock_.now().utc - started_) / std::max(1.0, clock_.speed());
  if (kind == "access.wrong_tries") return up_s >= kSilent_s;
  if (!description_.configured) return true;  // nothing is looked at
  if (!has_looked_) return false;
  if (kind != "access.ends" || !subject.starts_with("certificate of ")) return true;
  return looked_.proofs.contains(subject) || up_s >= kForgotten_s;
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
    looked_ = co_await run_on(texts_, &AccessDesk::look_at, description_, ends_);
    has_looked_ = true;
    const auto pause = nanoseconds_from_s(kLook_s * clock_.speed());
    co_await sleep_unless(clock_, clock_.now().utc + pause, ended_);
  }
}

}  // namespace driftwise::application
