#include "server/application/datasets/row_names.h"

#include "server/core/data/row_marks.h"

namespace driftwise::application {

std::string row_name(const std::vector<correction::RowOrigin>& origins, const Dataset& data,
                     std::size_t row) {
  if (origins.size() != data.rows || row >= data.rows) return "row " + std::to_string(row + 1);
  const RunId run = origins[row].run;
  while (row < data.rows && (is_passage(data, row) || origins[row].run != run)) ++row;
  const std::string of_run = "run " + std::to_string(run.value);
  if (row == data.rows) return "the end of " + of_run;
  return "row " + std::to_string(origins[row].row + 1) + " of " + of_run;
}

}  // namespace driftwise::application
