#pragma once
// Models of the record as a list shows them: each text is read once, not with every list.
//
// Thread: that of the store's reader alone.

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/ports/store.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

struct ListedModel {
  ModelRecord record;  // without its json
  // Figures, domain, lineage and the kind of robot: no terms, coefficients or rows. Null: the model
  // is damaged.
  std::shared_ptr<const calibration::Model> summary;
};

class ModelList {
 public:
  // In the order of their numbers; a damaged one with its damage. Errors: those of the store.
  Result<std::vector<ListedModel>> of(Store& store);

 private:
  struct Known {
    std::string hash;      // as it stands on record
    std::size_t text = 0;  // hash of the JSON: what was changed since is read again
    std::string damage;
    std::shared_ptr<const calibration::Model> summary;
  };
  static Known read(const ModelRecord& record);

  std::map<std::int64_t, Known> known_;
};

}  // namespace driftwise::application
