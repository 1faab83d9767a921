#pragma once
// The data sets and figures of tests/data/standards.

#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

#include "server/formats/csv/dataset_csv.h"
#include "server/standards/approaches.h"

namespace driftwise::standards {

inline std::string standards_file(const std::string& name) {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/tests/data/standards/" + name);
  if (!file) throw std::runtime_error("no file " + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline Dataset standards_dataset(const std::string& name) {
  auto data = formats::read_dataset_csv(standards_file(name), name);
  if (!data) throw std::runtime_error(data.error().message);
  return std::move(*data);
}

// name -> value, of one data set.
inline std::map<std::string, double> figures_by_r(const std::string& file) {
  std::istringstream lines(standards_file("expected.csv"));
  std::map<std::string, double> out;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(file + ",")) {
      const auto comma = line.rfind(',');
      const auto name = line.substr(file.size() + 1, comma - file.size() - 1);
      out[name] = std::stod(line.substr(comma + 1));
    }
  return out;
}

// A row per visit: what was commanded, and by how many nm the measurement differs.
inline Dataset visits_of(const std::vector<std::pair<double, double>>& visits) {
  Dataset data;
  data.rows = visits.size();
  data.columns = {{{"q1_cmd", "mm"}, {}}, {{"x", "mm"}, {}}};
  for (const auto& [target_mm, deviation_nm] : visits) {
    data.columns[0].values.push_back(target_mm);
    data.columns[1].values.push_back(target_mm + deviation_nm * 1e-6);
    data.time_s.push_back(10.0 * static_cast<double>(data.time_s.size()));
  }
  return data;
}

}  // namespace driftwise::standards
