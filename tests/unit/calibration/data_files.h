#pragma once
// Helpers of the calibration tests: data files of the repository, small datasets by hand, digits of
// agreement.

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::calibration {

using Row = std::vector<std::string>;

// Comma-separated lines of tests/data/<name>, "#" lines and nothing else left out.
inline std::vector<Row> read_rows(const std::string& name) {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/" + name);
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    Row row;
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) row.push_back(field);
    rows.push_back(std::move(row));
  }
  return rows;
}

// A dataset of dimensionless channels from a header row of symbols and rows of numbers.
inline Dataset dataset_of(const std::vector<Row>& rows) {
  Dataset data;
  for (const auto& symbol : rows.at(0)) data.columns.push_back({{symbol, "1"}, {}});
  for (std::size_t i = 1; i < rows.size(); ++i)
    for (std::size_t c = 0; c < data.columns.size(); ++c)
      data.columns[c].values.push_back(std::stod(rows[i].at(c)));
  data.rows = rows.size() - 1;
  return data;
}

inline Dataset columns_of(std::vector<std::pair<Channel, std::vector<double>>> columns) {
  Dataset data;
  for (auto& [channel, values] : columns) {
    data.rows = values.size();
    data.columns.push_back({channel, std::move(values)});
  }
  return data;
}

// Correct digits: -log10 of the relative error, at most 16.
inline double digits(double value, double certified) {
  const double error =
      certified == 0 ? std::abs(value) : std::abs(value - certified) / std::abs(certified);
  return error < 1e-16 ? 16 : -std::log10(error);
}

}  // namespace driftwise::calibration
