#pragma once
// Wrong tries, counted by where they come from; after some of them nothing from there is looked at
// for a while. Not thread safe: its owner has the lock. Instants are handed in.
//
// From one address: kFree tries at once, then a pause of 1 s that doubles with each further one up
// to kLongest. An hour without any forgets it. At most kMostKept addresses are kept, the oldest
// goes.

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

namespace driftwise::access {

class WrongTries {
 public:
  using Instant = std::chrono::steady_clock::time_point;
  static constexpr int kFree = 5;
  static constexpr std::chrono::seconds kLongest{60};
  static constexpr std::chrono::hours kForgotten{1};
  static constexpr std::size_t kMostKept = 4096;

  // How long this source has to wait still; 0: it may try.
  std::chrono::milliseconds must_wait(const std::string& source, Instant now) const;
  struct Count {
    std::int64_t tries = 0;              // in a row
    std::chrono::milliseconds pause{0};  // that begins now
  };
  Count wrong(const std::string& source, Instant now);
  void right(const std::string& source);

 private:
  struct Source {
    std::int64_t tries = 0;
    Instant last, until;
  };
  std::map<std::string, Source> sources_;
};

// The address without the port: "ipv4:10.0.0.2:4711" -> "ipv4:10.0.0.2"; of IPv6 its /64.
std::string source_of(const std::string& from);

}  // namespace driftwise::access
