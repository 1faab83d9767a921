#pragma once
// The record of an indentation as JSON: what a client keeps beside indentation.toml, from which it
// goes on.

#include <string>
#include <string_view>

#include "server/indentation/procedure.h"

namespace driftwise::formats {

std::string procedure_json(const indentation::ProcedureRecord& record);
// Errors: data_loss JSON_SYNTAX, BAD_VALUE, naming the file and the place.
Result<indentation::ProcedureRecord> read_procedure_json(std::string_view text,
                                                         const std::string& file_name);

}  // namespace driftwise::formats
