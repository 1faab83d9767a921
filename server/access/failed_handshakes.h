#pragma once
// TLS handshakes that failed at a door, as sentences for the log: one for each client and minute,
// with the number of those since. Any thread.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace driftwise::access {

class FailedHandshakes {
 public:
  using Instant = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::minutes kPause{1};
  static constexpr std::size_t kMostKept = 1024;  // clients; the one told longest ago goes

  explicit FailedHandshakes(std::string door) : door_(std::move(door)) {}

  // peer: without its port. why: of the TLS library; nothing in it is a secret.
  std::optional<std::string> note(const std::string& peer, const std::string& why, Instant now);

 private:
  struct Told {
    Instant at;
    std::int64_t silent = 0;
  };
  const std::string door_;
  std::mutex mutex_;
  std::map<std::string, Told> told_;
};

}  // namespace driftwise::access
