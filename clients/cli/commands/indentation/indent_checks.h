#pragma once
// An indentation's file against the cell that is to carry it out, before anything moves.

#include "clients/cli/core/connection.h"
#include "server/formats/indentation/indentation_file.h"

namespace driftwise::cli {

// Robots, instruments, temperatures and tool of the file are the cell's, and every place that is
// planned has motor coordinates inside the soft limits. Throws Failure, bad_input or that of the
// daemon's refusal: what the file says, what the cell has, what to do.
void check_against_cell(const Connection& connection, const formats::IndentationFile& file);

}  // namespace driftwise::cli
