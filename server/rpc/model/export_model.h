#pragma once
// A stored model as a file to carry away.

#include <string>

#include "driftwise/v1/model_service.pb.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::rpc {

// JSON: the stored text, indented. C: formats/model_c. head: of the record's chain, HASH@N, and
// when; both stand in the file, which so carries the head away; empty: the record has none. Errors:
// invalid_argument BAD_FORMAT; data_loss MODEL_DAMAGED; failed_precondition, where a term has no
// plain C form.
Result<v1::ExportModelResponse> export_model(const ModelRecord& record,
                                             v1::ExportModelRequest::Format format,
                                             const std::string& head, const std::string& at);

}  // namespace driftwise::rpc
