#pragma once
// Requests of clients that nobody knows yet, by address: kBurst at once, then kPerSecond. Bounded:
// kMostKept addresses, the one that asked longest ago goes. Web thread; instants are handed in.

#include <chrono>
#include <cstddef>
#include <map>
#include <string>

namespace driftwise::web {

class RequestRate {
 public:
  using Instant = std::chrono::steady_clock::time_point;
  static constexpr double kBurst = 400, kPerSecond = 50;  // a page's first load is some 30
  static constexpr std::size_t kMostKept = 4096;

  // source: an address without a port. False: too many, for about a second.
  bool takes(const std::string& source, Instant now);
  std::size_t size() const { return sources_.size(); }

 private:
  struct Source {
    double left = kBurst;
    Instant last;
  };
  std::map<std::string, Source> sources_;
};

}  // namespace driftwise::web
