#include "server/application/alarms/incidents.h"

#include <algorithm>
#include <cctype>

namespace driftwise::application {
namespace {

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
}

// As a word: "laser-x" is not in "laser-xy".
bool names(const std::string& text, const std::string& word) {
  if (word.empty()) return false;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const auto end = at + word.size();
    if ((at == 0 || !is_word(text[at - 1])) && (end == text.size() || !is_word(text[end])))
      return true;
  }
  return false;
}

// Everything but the port; a serial line is a host of its own.
std::string host_of(const std::string& address) {
  const auto colon = address.rfind(':');
  return colon == std::string::npos ? address : address.substr(0, colon);
}

// Whether `cause` explains `other`, their beginnings being `apart`.
bool explains(const AlarmCondition& cause, const AlarmCondition& other, Nanoseconds apart) {
  const bool together = apart >= Nanoseconds(0) && apart <= Nanoseconds(Incidents::kTogether);
  if (other.kind == "device.lost")
    return cause.kind == "device.lost" && together && !cause.address.empty() &&
           host_of(cause.address) == host_of(other.address);
  if (other.kind.starts_with("reading."))  // what is false in one channel is so in its neighbours
    return cause.kind == other.kind && together && !other.device.empty() &&
           cause.device == other.device;
  if (other.kind == "channel.stale") {
    if (cause.kind.starts_with("reading.")) return cause.subject == other.subject;
    if (cause.kind == "device.lost") return cause.subject == other.device;
    return cause.kind == "channel.stale" && together && cause.device == other.device;
  }
  if (other.kind == "run.waiting") {
    if (cause.kind == "run.paused" || cause.kind == "gate.given_up" || cause.kind == "gate.spread")
      return false;
    return names(other.detail, cause.subject) || names(other.detail, cause.address) ||
           other.detail == cause.message;
  }
  if (other.kind == "gate.given_up")
    return cause.kind == "gate.spread" && cause.subject == other.subject;
  return false;
}

// Kinds that another condition can explain which is seen later: an answer that does not come makes
// a run wait at once, and its device lost after some tries.
bool cause_may_come(const std::string& kind) {
  return kind == "run.waiting" || kind == "channel.stale";
}

}  // namespace

void Incidents::stand(const std::string& kind, const std::string& subject, CellTime since,
                      CellTime now) {
  auto& known = known_.try_emplace({kind, subject}, Known{since, now, {}, {}, true}).first->second;
  known.last_seen = now;
}

std::vector<AlarmCondition> Incidents::group(std::vector<AlarmCondition> conditions, CellTime now) {
  const auto key_of = [](const AlarmCondition& one) { return Key{one.kind, one.subject}; };
  for (const auto& one : conditions) {
    auto& known = known_.try_emplace(key_of(one), Known{now, now, {}, {}, false}).first->second;
    known.last_seen = now;
  }
  std::erase_if(known_, [&](const auto& entry) { return now - entry.second.last_seen > kGrace; });
  std::ranges::stable_sort(conditions, [&](const AlarmCondition& a, const AlarmCondition& b) {
    return known_.at(key_of(a)).since < known_.at(key_of(b)).since;
  });
  const auto present = [&](const Key& key) {
    return std::ranges::any_of(conditions, [&](const auto& one) { return key_of(one) == key; });
  };
  for (const auto& one : conditions) {
    auto& mine = known_.at(key_of(one));
    if (mine.cause && (present(*mine.cause) || one.is_ending)) mine.cause_seen = now;
    if (mine.cause && now - mine.cause_seen > kGrace) {
      mine.cause.reset();
      mine.own = true;
    }
    if (mine.own) continue;
    // One that may be over in a moment explains what nothing else does.
    std::vector<Key> causes;
    const auto find_causes = [&](bool settling) {
      for (const auto& other : conditions) {
        if (other.settling != settling) continue;
        const auto& its = known_.at(key_of(other));
        if (&other == &one || (its.since == mine.since && &other > &one && other.kind == one.kind))
          continue;
        if (!explains(other, one, mine.since - its.since)) continue;
        Key root = its.cause && present(*its.cause) ? *its.cause : key_of(other);
        if (root != key_of(one) && std::ranges::find(causes, root) == causes.end())
          causes.push_back(std::move(root));
      }
    };
    find_causes(false);
    if (causes.empty()) find_causes(true);
    if (causes.size() > 1) {  // either could be it
      mine.cause.reset();
    } else if (causes.size() == 1) {
      mine.cause = causes.front();
      mine.cause_seen = now;
    }
  }
  std::vector<AlarmCondition> out;
  for (auto& one : conditions) {
    auto& known = known_.at(key_of(one));
    if (known.cause) continue;
    one.settling =
        one.settling || (cause_may_come(one.kind) && !known.own && now - known.since < kTogether);
    if (!one.settling) known.own = true;
    out.push_back(one);
  }
  for (const auto& one : conditions) {
    const auto& cause = known_.at(key_of(one)).cause;
    if (!cause) continue;
    const auto alarm =
        std::ranges::find_if(out, [&](const auto& root) { return key_of(root) == *cause; });
    if (alarm != out.end()) alarm->consequences.push_back(one.message);
  }
  return out;
}

}  // namespace driftwise::application
