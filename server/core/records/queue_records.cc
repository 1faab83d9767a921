#include "server/core/records/queue_records.h"

#include <array>

namespace driftwise {
namespace {
constexpr std::array<std::string_view, 6> kQueueStates = {"waiting", "running",   "following",
                                                          "done",    "set aside", "removed"};
}  // namespace

std::string_view to_string(QueueState state) {
  return kQueueStates.at(static_cast<std::size_t>(state));
}

std::optional<QueueState> queue_state_from(std::string_view text) {
  for (std::size_t i = 0; i < kQueueStates.size(); ++i)
    if (kQueueStates[i] == text) return static_cast<QueueState>(i);
  return std::nullopt;
}

std::string_view to_string(OnFailure rule) {
  return rule == OnFailure::hold ? "hold" : "set-aside";
}

std::optional<OnFailure> on_failure_from(std::string_view text) {
  for (const auto rule : {OnFailure::hold, OnFailure::set_aside})
    if (to_string(rule) == text) return rule;
  return std::nullopt;
}

}  // namespace driftwise
