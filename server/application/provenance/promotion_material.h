#pragma once
// The questions before a model serves, in one list: whether it is promoted by itself or with the
// findings that it was made for.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/application/provenance/data_questions.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/store.h"
#include "server/core/records/run_metadata.h"
#include "server/core/utc_map.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::application {

// What the record says about the runs that a model is fitted from.
struct PromotionMaterial {
  std::vector<DataOfModel> data;
  std::vector<RunMetadata> metadata;
  // Cell files that they were measured under, each once, oldest first; empty: a file.
  std::vector<UsedConfiguration> configurations;
  std::optional<CellDescription> measured_under;  // the last of them; none: it cannot be read
  std::vector<formats::ConfigurationChange> changes_since;  // from it to the present one
  bool judged_later = false;               // a run that was measured afterwards judged the model
  std::vector<CorrectionRecord> rests_on;  // corrections of the rows, in force or not
};

// fitted: when; runs and cell files count up to then. judged_later and rests_on are the caller's.
// Errors: not_found NO_SUCH_RUN; those of the store. Called on the store's thread.
Result<PromotionMaterial> promotion_material(Store& store, const std::vector<RunId>& runs,
                                             CellTime fitted, const CellDescription& present);

struct PromotionQuestions {
  std::vector<std::string> all;           // sentences that follow "although"
  std::vector<std::string> for_a_reason;  // those of them that a reason in writing answers
};

// utc: of an instant of cell time. Pure.
PromotionQuestions questions_before_serving(const calibration::Model& model,
                                            const PromotionMaterial& material,
                                            const CellDescription& present,
                                            const std::function<UtcTime(CellTime)>& utc);

}  // namespace driftwise::application
