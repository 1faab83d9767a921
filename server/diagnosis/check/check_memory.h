#pragma once
// Effects with memory of a model on the rows of a run, with what the cell read before the run.
//
// In a fit such an effect begins in equilibrium at the first row. A run that is checked begins in
// any room, so its effects are computed over the readings before it. Each of them then is a channel
// of its own, and the rest of the check has no memory to look after.

#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/diagnosis/check/check_errors.h"

namespace driftwise::diagnosis {

// Channels that effects with a time constant observe, but coordinates: they have no readings
// between the points. An effect that observes a coordinate counts from the first row, as in a fit.
struct ModelMemory {
  std::vector<std::string> symbols;  // each once
  double longest_tau_s = 0;          // 0: the model has no such effect
};
ModelMemory memory_of(const calibration::Model& model);

// The model with those effects as channels; the i-th is named by its notation.
calibration::Model with_effects_as_channels(calibration::Model model);

// The run with the channels that this model then reads, at its rows and in its zeros. A value is
// missing until the channel was read for effects::kKnownTaus time constants; unknown_memory then
// says since when. Unchanged: the model has no such effect, or the data no times.
RunToCheck with_effects_as_channels(const calibration::Model& model, RunToCheck run);

// The run as run_errors() reads it of with_effects_as_channels(model): in the model's units, with
// its effects as channels, in the model's datum. Errors: UNITS_DISAGREE.
Result<RunToCheck> as_the_model_reads(const calibration::Model& model, RunToCheck run);

}  // namespace driftwise::diagnosis
