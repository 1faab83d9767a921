#include "server/rpc/model/export_model.h"

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/export/model_c.h"
#include "server/formats/model/model_json.h"

namespace driftwise::rpc {

Result<v1::ExportModelResponse> export_model(const ModelRecord& record,
                                             v1::ExportModelRequest::Format format,
                                             const std::string& head, const std::string& at) {
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
    std::string text = formats::write_model_json(*model, 2);
    if (!head.empty())
      text.insert(text.rfind("\n}"), ",\n  \"record_head\": \"" + head +
                                         "\",\n  \"record_head_time\": \"" + at + "\"");
    out.set_text(text + "\n");
    out.set_file_name("model_" + id + ".json");
    return out;
  }
  if (model->geometry)
    return fail(ErrorCode::failed_precondition, reasons::kBadFormat,
                "model " + id +
                    " is a robot's geometry, which is no sum of terms that a C function could "
                    "hold: export it as JSON");
  DRIFTWISE_TRY(auto source, formats::write_model_c(*model, id));
  if (!head.empty())
    source += "\n/* Head of the record's chain: " + head + " at " + at +
              " (driftwise audit verify --head) */\n";
  out.set_text(std::move(source));
  out.set_file_name("model_" + id + ".c");
  return out;
}

}  // namespace driftwise::rpc
