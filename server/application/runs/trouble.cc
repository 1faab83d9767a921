#include "server/application/runs/trouble.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "server/application/recording/device_bench.h"

namespace driftwise::application {
namespace {

// Refusals that the same question would meet again: a start check that ran out of time, a target
// that cannot be given.
constexpr std::array<std::string_view, 8> kFinal = {
    "STABILISER_OFF", "DRIFT_TOO_FAST",     "ZERO_NOT_REACHED", "NO_ZERO",
    "NO_MODEL",       "MISSING_COORDINATE", "NO_CONTROLLER",    "NO_LOAD"};

}  // namespace

bool is_of_weights(const Error& error) {
  return error.reason == "LOAD_JAMMED" || error.reason == "LOAD_SLOW" ||
         error.reason == "LOAD_BUSY";
}

Remedy remedy_for(const Error& error) {
  if (error.reason == "SHUTTING_DOWN") return Remedy::leave;
  if (error.reason == "RUN_ABORTED") return Remedy::abort;
  if (error.reason == "BEAM_LOST") return Remedy::new_datum;
  if (error.code == ErrorCode::aborted) return Remedy::hold;
  if (std::ranges::find(kFinal, error.reason) != kFinal.end()) return Remedy::fail;
  // A device that is away, and a device or thermometer that says "not now": both are looked at
  // again until they say something else. The engine counts, and asks for a person when nothing gets
  // better.
  if (is_device_loss(error) || error.code == ErrorCode::failed_precondition)
    return Remedy::wait_for_device;
  return Remedy::fail;
}

}  // namespace driftwise::application
