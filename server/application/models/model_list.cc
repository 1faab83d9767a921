#include "server/application/models/model_list.h"

#include <functional>
#include <utility>

#include "server/application/models/model_integrity.h"
#include "server/core/try.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

calibration::Model summary_of(calibration::Model model) {
  for (auto& output : model.outputs) {
    calibration::OutputModel kept;
    kept.channel = output.channel;
    kept.dof = output.dof;
    kept.accuracy = std::move(output.accuracy);
    output = std::move(kept);
  }
  model.datum_zeros.clear();
  if (model.geometry) {
    calibration::Geometry kept;
    kept.robot.kind = model.geometry->robot.kind;
    model.geometry = std::move(kept);
  }
  return model;
}

}  // namespace

// One model that this version cannot read is a damaged line, and the others are listed all the
// same.
ModelList::Known ModelList::read(const ModelRecord& record) {
  Known known{record.hash, std::hash<std::string>()(record.json), record.damage, nullptr};
  if (const auto whole = check_integrity(record); !whole) known.damage = whole.error().message;
  auto model = formats::read_model_json(record.json);
  if (!model && known.damage.empty())
    known.damage = "model " + std::to_string(record.id.value) +
                   " in the database cannot be read: " + model.error().message;
  if (model && known.damage.empty())
    known.summary = std::make_shared<const calibration::Model>(summary_of(std::move(*model)));
  return known;
}

Result<std::vector<ListedModel>> ModelList::of(Store& store) {
  DRIFTWISE_TRY(auto records, store.models().models());
  std::vector<ListedModel> listed;
  listed.reserve(records.size());
  for (ModelRecord& record : records) {
    auto& known = known_[record.id.value];
    const bool is_known = known.summary && record.damage.empty() && known.hash == record.hash &&
                          known.text == std::hash<std::string>()(record.json);
    if (!is_known) known = read(record);
    record.damage = known.damage;
    record.json.clear();
    record.json.shrink_to_fit();
    listed.push_back({std::move(record), known.summary});
  }
  return listed;
}

}  // namespace driftwise::application
