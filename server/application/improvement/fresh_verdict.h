#pragma once
// Verdict of fresh points on a gain, by the A90 of the model before and of the new one on the same
// points.

#include <optional>
#include <string>
#include <vector>

#include "server/application/checks/model_checks.h"
#include "server/core/records/diagnosis_records.h"

namespace driftwise::application {

struct FreshVerdict {
  bool judged = false;  // any output
  bool better = false;  // any output, by more than a twentieth
  std::string worse;    // outputs that got worse by more than a twentieth
  std::string measured;
};
FreshVerdict judge_fresh(const std::vector<TurnGain>& gains);

// Of an output, by its symbol; nothing where fewer than two rows were judged.
std::optional<ErrorFigures> fresh_figures(const ModelCheck& check, const std::string& symbol);

// Why a model's points were not judged, by the first output that says it.
std::string why_unjudged(const ModelCheck& check);

}  // namespace driftwise::application
