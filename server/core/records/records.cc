#include "server/core/records/records.h"

#include <array>

namespace driftwise {
namespace {
constexpr std::array<std::string_view, 7> kRunStates = {"queued", "running", "paused", "waiting",
                                                        "done",   "aborted", "failed"};
constexpr std::array<std::string_view, 6> kVerdicts = {"accepted", "reread",   "reapproach",
                                                       "requeued", "given_up", "interrupted"};
constexpr std::array<std::string_view, 7> kHoldKinds = {
    "", "pause", "stop", "trouble", "restart", "configuration", "condition"};
}  // namespace

std::string_view to_string(RunHold::Kind kind) {
  return kHoldKinds.at(static_cast<std::size_t>(kind));
}

std::optional<RunHold::Kind> hold_kind_from(std::string_view text) {
  for (std::size_t i = 0; i < kHoldKinds.size(); ++i)
    if (kHoldKinds[i] == text) return static_cast<RunHold::Kind>(i);
  return std::nullopt;
}

std::string_view to_string(RunState state) {
  return kRunStates.at(static_cast<std::size_t>(state));
}

std::optional<RunState> run_state_from(std::string_view text) {
  for (std::size_t i = 0; i < kRunStates.size(); ++i)
    if (kRunStates[i] == text) return static_cast<RunState>(i);
  return std::nullopt;
}

std::string_view to_string(Verdict verdict) {
  return kVerdicts.at(static_cast<std::size_t>(verdict));
}

}  // namespace driftwise
