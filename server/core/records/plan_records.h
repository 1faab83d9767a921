#pragma once
// Serving plans as the store keeps them (server/plans says what is in one).

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/ids.h"

namespace driftwise {

struct PlanRecord {
  PlanId id;
  std::string name;
  int version = 1;                                      // of this name, from 1: given by the store
  std::string text;                                     // plan.toml as it was given
  std::string hash;                                     // of the text
  std::vector<std::pair<ModelId, std::string>> models;  // that it names, each with its hash
  CellTime created;
  std::string created_by, created_from, note;
  std::string request_id;  // empty: none
};

struct PlanPromotionRecord {
  std::optional<PlanId> plan;  // none: no plan serves from here on
  CellTime at;
  std::string by, from;
  std::string action;  // promote | rollback
};

}  // namespace driftwise
