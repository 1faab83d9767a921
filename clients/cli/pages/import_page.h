#pragma once
// What `driftwise data import --mapping` understood of a file, for people and for programs.

#include <nlohmann/json.hpp>

#include "clients/cli/core/console.h"
#include "server/formats/import/import_dataset.h"

namespace driftwise::cli {

// A page: rows, times, groups, sets, what was left out, and one line per column.
void print_import(std::ostream& out, const Paint& paint, const formats::ImportReport& report);
// The first rows of the dataset as they will stand in its file.
void print_first_rows(std::ostream& out, const Dataset& dataset, std::size_t rows);

nlohmann::ordered_json json_from(const formats::ImportReport& report);

}  // namespace driftwise::cli
