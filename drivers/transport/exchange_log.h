#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

namespace driftwise::transport {

struct Exchange {
  std::int64_t number = 0;
  std::string sent, received;        // raw bytes, each cut to ExchangeLog::kMaxBytes
  std::chrono::nanoseconds took{0};  // wall time
  std::string outcome;               // empty: good
};

// The last few exchanges with a device, for `driftwise devices` and for whoever wonders what was on
// the wire.
class ExchangeLog {
 public:
  static constexpr std::size_t kMaxBytes = 512;
  explicit ExchangeLog(std::size_t capacity = 16) : capacity_(capacity) {}

  void add(Exchange exchange);
  const std::deque<Exchange>& entries() const { return entries_; }  // oldest first
  std::vector<std::string> lines() const;  // "#12 sent "POS?\n" got "X=0.1\n" after 0.08 ms"

 private:
  std::size_t capacity_;
  std::deque<Exchange> entries_;
};

std::string describe(const Exchange& exchange);

}  // namespace driftwise::transport
