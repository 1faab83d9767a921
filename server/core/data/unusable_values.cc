#include "server/core/data/unusable_values.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace driftwise {
namespace {

bool is_unusable(double value) { return std::abs(value) > kLargestUsable; }  // false for NaN

// Whole columns at once: every fit looks.
bool has_unusable(const DatasetColumn& column) {
  const Eigen::Map<const Eigen::ArrayXd> values(column.values.data(),
                                                static_cast<Eigen::Index>(column.values.size()));
  return (values.abs() > kLargestUsable).any();
}

std::string value_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

}  // namespace

std::optional<UsableDataset> without_unusable(const Dataset& dataset) {
  if (std::ranges::none_of(dataset.columns, has_unusable)) return std::nullopt;
  constexpr std::size_t kMostNamed = 20;
  std::vector<std::size_t> rows;
  std::vector<std::string> named;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    std::string what;
    for (const auto& column : dataset.columns)
      if (is_unusable(column.values[row]))
        what += (what.empty() ? "" : ", ") + column.channel.name() + " " +
                value_text(column.values[row]);
    if (what.empty()) continue;
    rows.push_back(row);
    if (named.size() < kMostNamed) named.push_back("row " + std::to_string(row + 1) + ": " + what);
  }
  if (rows.empty()) return std::nullopt;
  UsableDataset out{dataset, {}};
  for (auto& column : out.data.columns)
    for (const std::size_t row : rows)
      if (is_unusable(column.values[row])) column.values[row] = kMissing;
  out.sentence = std::to_string(rows.size()) + (rows.size() == 1 ? " row holds" : " rows hold") +
                 " values that no instrument can have measured, taken as missing (";
  for (std::size_t i = 0; i < named.size(); ++i) out.sentence += (i ? "; " : "") + named[i];
  if (rows.size() > named.size()) out.sentence += "; ...";
  out.sentence += ")";
  return out;
}

}  // namespace driftwise
