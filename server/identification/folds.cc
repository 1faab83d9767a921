#include "server/identification/folds.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "server/core/reasons.h"

namespace driftwise::identification {

std::vector<Fold> time_folds(const std::vector<std::size_t>& rows, int blocks, double gap) {
  std::vector<Fold> folds;
  const auto count = static_cast<std::ptrdiff_t>(rows.size());
  if (blocks < 2 || count < 3 * blocks) return folds;
  const auto begin_of = [&](std::ptrdiff_t block) { return count * block / blocks; };
  // A neighbour's rows next to the block: a share of the neighbour's own length.
  const auto margin_of = [&](std::ptrdiff_t block) {
    const std::ptrdiff_t length = begin_of(block + 1) - begin_of(block);
    return std::min<std::ptrdiff_t>(std::lround(gap * static_cast<double>(length)), length / 2);
  };
  for (std::ptrdiff_t b = 0; b < blocks; ++b) {
    const std::ptrdiff_t begin = begin_of(b), end = begin_of(b + 1);
    const std::ptrdiff_t before = b > 0 ? begin - margin_of(b - 1) : begin;
    const std::ptrdiff_t after = b + 1 < blocks ? end + margin_of(b + 1) : end;
    Fold fold;
    fold.train.assign(rows.begin(), rows.begin() + before);
    fold.train.insert(fold.train.end(), rows.begin() + after, rows.end());
    fold.test.assign(rows.begin() + begin, rows.begin() + end);
    folds.push_back(std::move(fold));
  }
  return folds;
}

Result<std::vector<int>> group_labels(const Dataset& dataset, const std::string& by) {
  std::vector<std::vector<double>> keys(dataset.rows);
  if (by == "line") {
    if (dataset.line.empty())
      return fail(ErrorCode::invalid_argument, reasons::kNoLines,
                  "rows cannot be kept together by line: the data have no line column");
    for (std::size_t row = 0; row < dataset.rows; ++row)
      keys[row].push_back(static_cast<double>(dataset.line[row]));
  } else {
    for (std::size_t at = 0; at <= by.size();) {
      const std::size_t comma = std::min(by.find(',', at), by.size());
      const std::string symbol = by.substr(at, comma - at);
      const DatasetColumn* column = dataset.find(symbol);
      if (column == nullptr) {
        std::string known = dataset.line.empty() ? "" : "line";
        for (const auto& one : dataset.columns)
          known += (known.empty() ? "" : " ") + one.channel.symbol;
        return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                    "rows cannot be kept together by '" + symbol.substr(0, 80) +
                        "', the data have: " + known);
      }
      for (std::size_t row = 0; row < dataset.rows; ++row) keys[row].push_back(column->values[row]);
      at = comma + 1;
    }
  }
  std::map<std::vector<double>, int> seen;
  std::vector<int> labels;
  for (auto& key : keys) {
    for (double& value : key)  // a missing value is a group of its own kind, and compares
      if (std::isnan(value)) value = HUGE_VAL;
    labels.push_back(seen.try_emplace(std::move(key), static_cast<int>(seen.size())).first->second);
  }
  return labels;
}

std::vector<Fold> group_folds(const std::vector<std::size_t>& rows, const std::vector<int>& labels,
                              int folds) {
  std::map<int, int> fold_of;
  for (const std::size_t row : rows)
    fold_of.try_emplace(labels[row], static_cast<int>(fold_of.size()) % std::max(folds, 1));
  if (folds < 2 || static_cast<int>(fold_of.size()) < folds) return {};
  std::vector<Fold> result(static_cast<std::size_t>(folds));
  for (const std::size_t row : rows) {
    const int home = fold_of.at(labels[row]);
    for (int f = 0; f < folds; ++f) {
      auto& fold = result[static_cast<std::size_t>(f)];
      (f == home ? fold.test : fold.train).push_back(row);
    }
  }
  return result;
}

}  // namespace driftwise::identification
