#pragma once
// A fitted method with its accuracy: JSON for programs, a page for people. docs/models.md.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "server/identification/accuracy.h"

namespace driftwise::formats {

// driftwise.method.v1: lengths summarised in nm, angles in arcsec, always named in the key;
// parameters in the unit their name ends in. formula: "" where there was none.
nlohmann::ordered_json method_json(const identification::Judgement& judgement,
                                   const std::string& formula);

// driftwise.comparison.v1: several of them on the same rows.
nlohmann::ordered_json comparison_json(const std::vector<identification::Judgement>& judgements,
                                       const std::string& formula);

// One method: its parameters with standard errors, what is held and why, its accuracy.
std::string method_page(const identification::Judgement& judgement, const std::string& formula);

// Several methods side by side.
std::string comparison_table(const std::vector<identification::Judgement>& judgements);

}  // namespace driftwise::formats
