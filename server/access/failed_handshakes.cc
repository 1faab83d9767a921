#include "server/access/failed_handshakes.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/core/text/clean_text.h"

namespace driftwise::access {
namespace {

// Remedies, by a part of OpenSSL's sentence.
constexpr std::array<std::pair<const char*, const char*>, 6> kRemedies = {{
    {"certificate verify failed",
     "the client's certificate has ended, or another authority signed it: make one with "
     "'driftwise cert client'"},
    {"unknown ca",
     "the client does not trust this daemon's authority: give it authority.pem of 'driftwise cert "
     "init'"},
    {"bad certificate", "the client does not accept this daemon's certificate: look at its names"},
    {"http request", "the client does not speak TLS: write https:// there"},
    {"unsupported protocol", "the client's TLS is older than 1.2"},
    {"wrong version number", "the client does not speak TLS"},
}};

}  // namespace

std::optional<std::string> FailedHandshakes::note(const std::string& peer, const std::string& why,
                                                  Instant now) {
  std::int64_t silent = 0;
  {
    const std::lock_guard lock(mutex_);
    const auto found = told_.find(peer);
    if (found != told_.end() && now - found->second.at < kPause) {
      ++found->second.silent;
      return std::nullopt;
    }
    if (found == told_.end() && told_.size() >= kMostKept)
      told_.erase(
          std::ranges::min_element(told_, {}, [](const auto& one) { return one.second.at; }));
    auto& told = told_[peer];
    silent = std::exchange(told.silent, 0);
    told.at = now;
  }
  std::string sentence = door_ + ": the TLS handshake with " + peer + " failed: " + clean_line(why);
  for (const auto& [part, remedy] : kRemedies)
    if (why.find(part) != std::string::npos) {
      sentence += std::string("; ") + remedy;
      break;
    }
  if (silent > 0) sentence += " (" + std::to_string(silent) + " more from there before)";
  return sentence;
}

}  // namespace driftwise::access
