#include "clients/cli/pages/serving_text.h"

namespace driftwise::cli {

std::string serving_text(const v1::GetStatusResponse& status, const v1::ListPlansResponse& plans) {
  std::string text;
  if (status.has_serving_model_id()) text = "model " + std::to_string(status.serving_model_id());
  for (const auto& plan : plans.plans())
    if (plan.serves())
      text += (text.empty() ? "plan " : ", plan ") + std::to_string(plan.id()) + " (" +
              plan.name() + ")";
  return text.empty() ? "no model: driftwise model promote N" : text;
}

}  // namespace driftwise::cli
