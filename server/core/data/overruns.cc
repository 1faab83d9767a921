#include "server/core/data/overruns.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace driftwise {
namespace {

struct Turn {
  std::size_t row = 0, column = 0;
  double beyond = 0;  // where the coordinate stood in between
};

double smallest_move(const std::vector<double>& values) {
  double smallest = INFINITY;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (const double move = std::abs(values[i] - values[i - 1]); move > 0)
      smallest = std::min(smallest, move);
  return smallest;
}

// Turns in the order of the rows.
std::vector<Turn> turns_of(const Dataset& dataset) {
  std::vector<std::size_t> coordinates;
  for (std::size_t c = 0; c < dataset.columns.size(); ++c) {
    const auto symbol = without_robot(dataset.columns[c].channel.symbol);
    if (is_motor_symbol(symbol) || is_pose_symbol(symbol)) coordinates.push_back(c);
  }
  // Motors say where a machine was sent; without them the nominal pose does.
  const auto is_motor = [&](std::size_t c) {
    return is_motor_symbol(without_robot(dataset.columns[c].channel.symbol));
  };
  if (std::ranges::any_of(coordinates, is_motor))
    std::erase_if(coordinates, [&](std::size_t c) { return !is_motor(c); });
  const auto move = [&](std::size_t c, std::size_t row) {
    const auto& values = dataset.columns[c].values;
    return values[row] - values[row - 1];
  };
  std::vector<double> half_move(dataset.columns.size());
  for (const std::size_t c : coordinates)
    half_move[c] = smallest_move(dataset.columns[c].values) / 2;
  std::vector<Turn> turns;
  for (std::size_t row = 2; row + 1 < dataset.rows; ++row) {
    if (!std::ranges::all_of(coordinates, [&](std::size_t c) { return move(c, row) == 0; }))
      continue;
    for (const std::size_t c : coordinates) {
      const double before = move(c, row - 1), after = move(c, row + 1);
      if (!(before * after < 0)) continue;
      turns.push_back(
          {row, c, dataset.columns[c].values[row] + std::copysign(half_move[c], before)});
    }
  }
  return turns;
}

// The first target too is reached from where its way leads on: each coordinate that turns stands
// short of it before.
std::vector<Turn> with_the_start(std::vector<Turn> turns, const Dataset& dataset) {
  std::vector<Turn> start;
  for (const Turn& turn : turns) {
    const auto same = [&](const Turn& one) { return one.column == turn.column; };
    if (std::ranges::any_of(start, same)) continue;
    const auto& values = dataset.columns[turn.column].values;
    const auto moved = std::ranges::find_if(values, [&](double v) { return v != values[0]; });
    if (moved == values.end()) continue;
    start.push_back(
        {0, turn.column, values[0] - std::copysign(smallest_move(values) / 2, *moved - values[0])});
  }
  turns.insert(turns.begin(), start.begin(), start.end());
  return turns;
}

template <class Value>
void repeat(std::vector<Value>& values, std::size_t row) {
  if (values.empty()) return;
  const Value value = values[row];
  values.insert(values.begin() + static_cast<std::ptrdiff_t>(row), value);
}

}  // namespace

bool says_overruns(const Dataset& dataset) {
  return std::ranges::any_of(dataset.metadata, [](const auto& line) {
    return line.first == kOverruns && line.second == "yes";
  });
}

std::vector<std::size_t> rows_after_overruns(const Dataset& dataset) {
  std::vector<std::size_t> rows;
  for (const Turn& turn : turns_of(dataset))
    if (rows.empty() || rows.back() != turn.row) rows.push_back(turn.row);
  return rows;
}

WholePath with_overruns(const Dataset& dataset) {
  const auto turns = with_the_start(turns_of(dataset), dataset);
  WholePath whole{dataset, {}};
  std::vector<std::size_t> rows;  // that have another one before them, from the last
  auto turn = turns.rbegin();
  while (turn != turns.rend()) {  // from the end: earlier rows keep their numbers
    const std::size_t row = turn->row;
    rows.push_back(row);
    auto& data = whole.data;
    repeat(data.time_s, row), repeat(data.set, row), repeat(data.line, row);
    repeat(data.zero, row), repeat(data.dwell_s, row), repeat(data.run, row);
    repeat(data.datum, row), repeat(data.excluded, row);
    for (auto& column : data.columns) repeat(column.values, row);
    for (; turn != turns.rend() && turn->row == row; ++turn)
      data.columns[turn->column].values[row] = turn->beyond;
    ++data.rows;
  }
  std::size_t further = 0;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (further < rows.size() && rows[rows.size() - 1 - further] == row) ++further;
    whole.kept.push_back(row + further);
  }
  return whole;
}

}  // namespace driftwise
