#pragma once
// What one client of Watch was told of diagnoses and improvements. Their progress is a state, which
// comes from the cell; that they were made and how they ended is on record. The record knows only
// that a job runs, so what it says must never take back what the cell said before. Pure.

#include <cstdint>
#include <map>
#include <optional>

#include "driftwise/v1/watch_service.pb.h"

namespace driftwise::rpc {

class JobsTold {
 public:
  // Both: an event of a diagnosis or an improvement; any other passes. Nothing: no news.
  std::optional<v1::WatchEvent> from_cell(const v1::WatchEvent& event);
  std::optional<v1::WatchEvent> from_record(v1::WatchEvent event);

 private:
  std::map<std::int64_t, v1::DiagnosisProgress> diagnoses_;  // under way, as they were told last
  std::map<std::int64_t, v1::ImprovementProgress> improvements_;
};

}  // namespace driftwise::rpc
