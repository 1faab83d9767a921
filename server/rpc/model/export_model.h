#pragma once
// A stored model as a file to carry away.

#include "driftwise/v1/model_service.pb.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::rpc {

// JSON: the stored text, indented. C: formats/model_c. Errors: invalid_argument BAD_FORMAT;
// data_loss MODEL_DAMAGED; failed_precondition, where a term has no plain C form.
Result<v1::ExportModelResponse> export_model(const ModelRecord& record,
                                             v1::ExportModelRequest::Format format);

}  // namespace driftwise::rpc
