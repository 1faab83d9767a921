#include "server/rpc/model/export_model.h"

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/export/model_c.h"
#include "server/formats/model/model_json.h"

namespace driftwise::rpc {

Result<v1::ExportModelResponse> export_model(const ModelRecord& record,
                                             v1::ExportModelRequest::Format format) {
  if (format != v1::ExportModelRequest::FORMAT_JSON && format != v1::ExportModelRequest::FORMAT_C)
    return fail(ErrorCode::invalid_argument, reasons::kBadFormat,
                "format: expected FORMAT_JSON or FORMAT_C");
  const std::string id = std::to_string(record.id.value);
  const auto model = formats::read_model_json(record.json);
  if (!model)
    return fail(ErrorCode::data_loss, reasons::kModelDamaged,
                "model " + id + " in the database cannot be read: " + model.error().message);
  v1::ExportModelResponse out;
  if (format == v1::ExportModelRequest::FORMAT_JSON) {
    out.set_text(formats::write_model_json(*model, 2) + "\n");
    out.set_file_name("model_" + id + ".json");
    return out;
  }
  DRIFTWISE_TRY(auto source, formats::write_model_c(*model, id));
  out.set_text(std::move(source));
  out.set_file_name("model_" + id + ".c");
  return out;
}

}  // namespace driftwise::rpc
