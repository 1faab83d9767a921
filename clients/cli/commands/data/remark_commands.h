#pragma once
// What people say about the record: `data exclude`, `data restore`, `data exclusions`, `note add`,
// `note list`; and notes as other pages show them.

#include <cstdint>
#include <optional>
#include <vector>

#include "clients/cli/core/session.h"
#include "driftwise/v1/data_service.pb.h"

namespace driftwise::cli {

void add_exclusion_commands(CLI::App& data, Session& session);  // below `data`
void add_note_commands(CLI::App& app, Session& session);

// Asks the daemon. Of a run or of a model.
v1::ListNotesResponse notes_of_run(const Connection& connection, std::int64_t run_id);
v1::ListNotesResponse notes_of_model(const Connection& connection, std::int64_t model_id);
// A line per note under a heading; nothing when there is none.
void print_notes(const Console& console, const v1::ListNotesResponse& notes);

}  // namespace driftwise::cli
