#include "server/diagnosis/rows/motor_places.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "server/diagnosis/rows/places.h"

namespace driftwise::diagnosis {
namespace {

// One block's place: the scaled coordinates of its first learning row.
std::vector<std::vector<double>> places_of_blocks(const Problem& problem) {
  const Dataset& data = problem.prepared.conditions();
  std::vector<std::vector<double>> columns;
  const auto add = [&](bool motors) {
    for (const auto& column : data.columns) {
      const auto& symbol = column.channel.symbol;
      if (motors ? !is_motor_symbol(symbol) : !is_coordinate(problem, column.channel)) continue;
      auto values = by_places(column.values);
      double low = INFINITY, high = -INFINITY;
      for (const std::size_t row : problem.learn)
        if (std::isfinite(values[row]))
          low = std::min(low, values[row]), high = std::max(high, values[row]);
      if (!(high > low)) continue;
      for (double& value : values)
        value = std::isfinite(value) ? std::round(1e4 * (value - low) / (high - low)) : 0;
      columns.push_back(std::move(values));
    }
  };
  add(true);
  if (columns.empty()) add(false);
  std::vector<std::vector<double>> result(static_cast<std::size_t>(problem.timeline.rows()));
  for (std::size_t i = problem.learn.size(); i-- > 0;) {
    auto& place = result[problem.block_of[i]];
    place.clear();
    for (const auto& column : columns) place.push_back(column[problem.learn[i]]);
  }
  return result;
}

}  // namespace

MotorPlaces motor_places(const Problem& problem) {
  MotorPlaces result;
  const auto of_block = places_of_blocks(problem);
  if (of_block.empty() || of_block.front().empty()) return result;
  std::map<std::vector<double>, std::size_t> index;
  for (const auto& place : of_block) {
    const auto [at, fresh] = index.emplace(place, result.places.size());
    if (fresh) result.places.push_back(place);
    result.of_block.push_back(at->second);
  }
  return result;
}

}  // namespace driftwise::diagnosis
