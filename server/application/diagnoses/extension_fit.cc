#include "server/application/diagnoses/extension_fit.h"

#include "server/application/models/fit_options.h"
#include "server/calibration/placed_terms.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

// Every term of these findings, in the outputs that show it by themselves.
std::vector<calibration::PlacedTerm> placed_by(const std::vector<diagnosis::Finding>& findings) {
  std::vector<calibration::PlacedTerm> placed;
  for (const auto& finding : findings) {
    std::vector<std::string> outputs;
    for (const auto& output : finding.outputs)
      if (output.shown) outputs.push_back(output.output);
    for (const auto& term : finding.terms)
      placed.push_back({term, outputs, finding.cause == "step_change"});
  }
  return placed;
}

Result<calibration::Model> fitted(const ExtensionPlan& plan, const Dataset& data,
                                  const FitRequest& request) {
  DRIFTWISE_TRY(auto options, fit_options_from(request, data, source_of(request)));
  DRIFTWISE_TRY(const auto formula, formats::Formula::parse(plan.baseline));
  DRIFTWISE_TRY(auto candidates, formula.expand(data));
  options.candidates = std::move(candidates);
  return calibration::fit_placed(data, std::move(options), placed_by(plan.of_robot), plan.formula);
}

}  // namespace

Result<ModelRecord> fit_extension(const ExtensionPlan& plan, const Dataset& data,
                                  FitRequest request) {
  auto model = fitted(plan, data, request);
  if (!model && model.error().reason == reasons::kRankDeficient) {
    request.select = "stepwise";
    model = fitted(plan, data, request);
  }
  DRIFTWISE_RETURN_IF_ERROR(model);
  ModelRecord record;
  record.name = request.name.empty() ? model->formula : request.name;
  record.note = request.note;
  record.json = formats::write_model_json(*model);
  record.hash = formats::model_hash(*model);
  record.parent = model->lineage.parent;
  return record;
}

}  // namespace driftwise::application
