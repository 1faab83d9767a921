#include "server/application/provenance/promotion_material.h"

#include <algorithm>
#include <utility>

#include "server/application/provenance/data_of_model.h"
#include "server/application/provenance/promotion_questions.h"
#include "server/application/provenance/stored_description.h"
#include "server/core/try.h"

namespace driftwise::application {

Result<PromotionMaterial> promotion_material(Store& store, const std::vector<RunId>& runs,
                                             CellTime fitted, const CellDescription& present) {
  PromotionMaterial material;
  for (const RunId run : runs) {
    DRIFTWISE_TRY(const auto used, store.configurations().of_run(run));
    for (const auto& one : used)
      if (one.from <= fitted &&
          std::ranges::find(material.configurations, one.hash, &UsedConfiguration::hash) ==
              material.configurations.end())
        material.configurations.push_back(one);
    DRIFTWISE_TRY(auto of_run, store.runs().run(run));
    material.metadata.push_back(std::move(of_run.metadata));
  }
  std::ranges::stable_sort(material.configurations, {}, &UsedConfiguration::from);
  if (!material.configurations.empty()) {
    const auto& last = material.configurations.back().hash;
    material.measured_under = stored_description(store, last, present);
    if (last != present.hash) {
      DRIFTWISE_TRY(const auto text, store.configurations().text(last));
      material.changes_since = formats::cell_file_difference(text, present);
    }
  }
  DRIFTWISE_TRY(material.data, data_of_model(store, runs, fitted));
  return material;
}

PromotionQuestions questions_before_serving(const calibration::Model& model,
                                            const PromotionMaterial& material,
                                            const CellDescription& present,
                                            const std::function<UtcTime(CellTime)>& utc) {
  PromotionQuestions asked;
  asked.for_a_reason = accuracy_questions(model, material.metadata);
  for (auto& questions :
       {asked.for_a_reason, imported_geometry_questions(model),
        origin_questions(model, material.data, present),
        campaign_questions(model, material.data, present, material.judged_later),
        temperature_questions(model, present), correction_questions(material.rests_on, utc),
        configuration_questions(model, material.changes_since)})
    asked.all.insert(asked.all.end(), questions.begin(), questions.end());
  return asked;
}

}  // namespace driftwise::application
