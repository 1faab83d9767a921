#include "server/core/records/diagnosis_records.h"

#include <array>

namespace driftwise {
namespace {

constexpr std::array<std::string_view, 4> kJobStates = {"running", "done", "cancelled", "failed"};

}  // namespace

std::string_view to_string(JobState state) { return kJobStates[static_cast<std::size_t>(state)]; }

std::optional<JobState> job_state_from(std::string_view text) {
  for (std::size_t i = 0; i < kJobStates.size(); ++i)
    if (kJobStates[i] == text) return static_cast<JobState>(i);
  return std::nullopt;
}

}  // namespace driftwise
