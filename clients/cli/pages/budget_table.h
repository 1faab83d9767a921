#pragma once
// A target's uncertainty, line by line, the motor coordinates side by side.

#include <string>

#include "clients/cli/core/console.h"
#include "driftwise/v1/target_service.pb.h"

namespace driftwise::cli {

// Rows: the sources, each with what it is (A: from the measurements, B: declared); then the
// combined standard uncertainty and the expanded one, k = 2. Nothing when no coordinate has a
// budget.
void print_budget(const Console& console,
                  const google::protobuf::RepeatedPtrField<v1::MotorCoordinate>& coordinates);

// Name of a line in the table: "laser".
std::string budget_line_name(const v1::BudgetLine& line);

}  // namespace driftwise::cli
