#include "server/rpc/shared/wire_time.h"

#include <atomic>

namespace driftwise::rpc {
namespace {

std::atomic<const application::Host*> g_mapping{nullptr};

}  // namespace

void map_times_by(const application::Host* host) { g_mapping = host; }

void stop_mapping_times_by(const application::Host* host) {
  g_mapping.compare_exchange_strong(host, nullptr);
}

UtcTime utc_from(CellTime instant) {
  const auto* host = g_mapping.load();
  return host ? host->utc(instant) : UtcTime{instant.utc_ns};
}

CellTime cell_time_from(UtcTime utc) {
  const auto* host = g_mapping.load();
  return host ? host->cell_time(utc) : CellTime{utc.ns};
}

}  // namespace driftwise::rpc
