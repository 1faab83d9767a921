// driftwise_lies [linear-axis|micro-nano ...]: the table of lies as Markdown on the output.
// Ends with 1 when something that is demanded is not so.

#include <spdlog/spdlog.h>

#include <iostream>

#include "tests/faults/lies/lie_table.h"

int main(int count, char** arguments) {
  spdlog::set_level(spdlog::level::off);  // the output is the table
  std::vector<std::string> cells(arguments + 1, arguments + count);
  if (cells.empty()) cells = {"linear-axis", "micro-nano"};
  int problems = 0;
  for (const auto& cell : cells)
    problems += driftwise::lies::print_table(cell, driftwise::lies::Effort::whole, std::cout);
  return problems == 0 ? 0 : 1;
}
