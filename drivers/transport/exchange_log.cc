#include "drivers/transport/exchange_log.h"

#include <cstdio>

#include "drivers/transport/escape.h"

namespace driftwise::transport {

void ExchangeLog::add(Exchange exchange) {
  if (exchange.sent.size() > kMaxBytes) exchange.sent.resize(kMaxBytes);
  if (exchange.received.size() > kMaxBytes) exchange.received.resize(kMaxBytes);
  if (entries_.size() >= capacity_) entries_.pop_front();
  entries_.push_back(std::move(exchange));
}

std::string describe(const Exchange& exchange) {
  char took[32];
  std::snprintf(took, sizeof took, "%.2f ms", static_cast<double>(exchange.took.count()) * 1e-6);
  std::string out = "sent \"" + escaped(exchange.sent) + "\", got ";
  out += exchange.received.empty() ? "nothing" : "\"" + escaped(exchange.received) + "\"";
  return out + " after " + took;
}

std::vector<std::string> ExchangeLog::lines() const {
  std::vector<std::string> out;
  for (const auto& entry : entries_) {
    out.push_back("#" + std::to_string(entry.number) + " " + describe(entry) +
                  (entry.outcome.empty() ? "" : ": " + entry.outcome));
  }
  return out;
}

}  // namespace driftwise::transport
