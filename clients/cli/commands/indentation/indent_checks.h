#pragma once
// An indentation's file against the cell that is to carry it out, before anything moves.

#include <string>
#include <vector>

#include "clients/cli/core/connection.h"
#include "server/formats/indentation/indentation_file.h"

namespace driftwise::cli {

// Robots, instruments, temperatures and tool of the file are the cell's, every place that is
// planned has motor coordinates inside the soft limits, and what the procedure reads is being read:
// it waits 20 s for it at most. Throws Failure, bad_input or that of the
// daemon's refusal: what the file says, what the cell has, what to do.
void check_against_cell(const Connection& connection, const formats::IndentationFile& file);

// Names that a coordinate has among live values, the instrument's own first: "mn.x_mm" is
// mn.x_path_mm in a cell with [correction], "mn.rx_arcsec" is mn.rx_raw_arcsec outside a run.
std::vector<std::string> live_names(const std::string& coordinate);

}  // namespace driftwise::cli
