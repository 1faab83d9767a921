#pragma once
// What a join of runs reports, as JSON (driftwise.join.v1, docs/joined-runs.md) and in the metadata
// of the joined dataset; and a dataset file as a part of a join.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "server/core/result.h"
#include "server/correction/dataset_join.h"

namespace driftwise::formats {

// parts: as they were joined; their data are asked for their row counts only.
nlohmann::ordered_json join_json(const correction::JoinParts& parts,
                                 const correction::JoinRules& rules,
                                 const correction::JoinReport& report);

// Lines of the joined dataset: its parts with their hashes, and where each pose coordinate comes
// from with its uncertainty.
std::vector<std::pair<std::string, std::string>> join_metadata(
    const correction::JoinParts& parts, const correction::JoinRules& rules,
    const correction::JoinReport& report);

// The file's "# tool: cube" and "# compensation: run 4 with model 3" say what it was measured with.
// Errors: those of read_dataset_csv.
Result<correction::JoinPart> read_join_part(std::string_view csv, const std::string& file_name);

}  // namespace driftwise::formats
