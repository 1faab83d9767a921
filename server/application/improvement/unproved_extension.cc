#include "server/application/improvement/unproved_extension.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "server/core/try.h"

namespace driftwise::application {
namespace {

bool is_judged(const ImprovementTurn& turn) {
  return std::ranges::any_of(
      turn.gains, [](const TurnGain& gain) { return gain.measured && gain.measured_before; });
}

// Of the last turn, where this improvement accepted it and it is in force.
Result<std::optional<ExtensionRecord>> unproved_extension(Store& store,
                                                          const ImprovementRecord& improvement) {
  std::optional<ExtensionRecord> found;
  if (improvement.turns.empty()) return found;
  const auto& turn = improvement.turns.back();
  if (!turn.diagnosis || is_judged(turn)) return found;
  DRIFTWISE_TRY(found, store.extensions().extension(*turn.diagnosis));
  if (found && !found->stands()) found.reset();
  return found;
}

}  // namespace

Result<std::string> end_interrupted_improvement(Store& store, const Stamp& now) {
  DRIFTWISE_TRY(const auto newest, store.improvements().improvements(1));  // one at a time
  if (newest.empty() || newest.front().state != JobState::running) return std::string();
  const auto& improvement = newest.front();
  std::string reason = "the daemon ended while it ran; its runs stay";
  DRIFTWISE_TRY(const auto extension, unproved_extension(store, improvement));
  if (extension) {
    const auto id = extension->diagnosis;
    DRIFTWISE_TRY(const auto promotions, store.models().promotions());
    if (extension->model && !promotions.empty() && promotions.back().model == extension->model) {
      reason += fmt::format("; diagnosis {} stays in force without proof, for its model serves",
                            id.value);
    } else {
      DRIFTWISE_RETURN_IF_ERROR(
          store.extensions().undo_extension(id, now, improvement.created_by, ""));
      reason += fmt::format("; diagnosis {} was undone: no fresh points show its gain", id.value);
    }
  }
  DRIFTWISE_RETURN_IF_ERROR(
      store.improvements().end_improvement(improvement.id, JobState::failed, reason, now.utc));
  return fmt::format("improvement {} failed: {}", improvement.id.value, reason);
}

}  // namespace driftwise::application
