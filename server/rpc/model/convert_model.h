#pragma once
// Models and promotions: domain -> proto. Coefficients stay in the column's unit; accuracy,
// contributions and the selection's history are given in the summary unit (nm, arcsec), as
// everywhere people read them.

#include <optional>
#include <span>

#include "driftwise/v1/model_service.pb.h"
#include "server/application/models/model_list.h"
#include "server/calibration/model/model.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::rpc {

enum class ModelDetail { whole, summary };  // summary: without terms and history

// serving: the model that serves now. before: what its accuracy is compared with; null: nothing.
// Errors: data_loss, MODEL_DAMAGED, when the stored JSON cannot
// be read.
Result<v1::Model> model_from(const ModelRecord& record, std::optional<ModelId> serving,
                             ModelDetail detail, const ModelRecord* before = nullptr);

// A line of a list, in summary; of a damaged model the record alone.
v1::Model model_from(const application::ListedModel& listed, std::optional<ModelId> serving);

v1::Promotion promotion_from(const PromotionRecord& promotion);

// Term by term over the models: every output and term that any of them was offered, in the order
// first met.
v1::CompareModelsResponse comparison_of(std::span<const v1::Model> models);

}  // namespace driftwise::rpc
