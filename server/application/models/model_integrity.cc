#include "server/application/models/model_integrity.h"

#include <fmt/format.h>

#include "server/core/reasons.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {

Result<void> check_integrity(const ModelRecord& model) {
  const auto damaged = [&model](const std::string& how) {
    return fail(ErrorCode::data_loss, reasons::kModelDamaged,
                fmt::format("model {} '{}' in the database is damaged: {}; promote another model, "
                            "or restore the database from a backup",
                            model.id.value, model.name, how));
  };
  if (!model.damage.empty()) return damaged(model.damage);
  const auto found = formats::stored_model_hash(model.json, model.hash);
  if (!found) return damaged(found.error().message);
  if (*found == model.hash) return {};
  return damaged(
      fmt::format("its content has the hash {}, it was stored with {}", *found, model.hash));
}

Result<calibration::Model> read_formula_model(const ModelRecord& record, const std::string& what) {
  auto model = formats::read_model_json(record.json);
  if (!model || !model->geometry) return model;
  return fail(ErrorCode::failed_precondition, reasons::kNoFormula,
              fmt::format("model {} is a robot's geometry ({}): {} for models of a formula alone; "
                          "driftwise model compare FILE --kinematics judges a geometry on rows",
                          record.id.value, model->geometry->robot.kind, what));
}

}  // namespace driftwise::application
