#include "server/rpc/shared/wire_time.h"

#include <atomic>

namespace driftwise::rpc {
namespace {

std::atomic<const application::Cell*> g_mapping{nullptr};

}  // namespace

void map_times_by(const application::Cell* cell) { g_mapping = cell; }

void stop_mapping_times_by(const application::Cell* cell) {
  g_mapping.compare_exchange_strong(cell, nullptr);
}

UtcTime utc_from(CellTime instant) {
  const auto* cell = g_mapping.load();
  return cell ? cell->utc(instant) : UtcTime{instant.utc_ns};
}

CellTime cell_time_from(UtcTime utc) {
  const auto* cell = g_mapping.load();
  return cell ? cell->cell_time(utc) : CellTime{utc.ns};
}

}  // namespace driftwise::rpc
