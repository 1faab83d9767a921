#include "server/core/data/overruns.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace driftwise {
namespace {

// Before `row` the coordinate stood further on by `part` of its move to the row `along`.
struct Turn {
  std::size_t row = 0, column = 0, along = 0;
  double part = 0;
};

using Columns = std::vector<std::size_t>;

double smallest_move(const std::vector<double>& values) {
  double smallest = INFINITY;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (const double move = std::abs(values[i] - values[i - 1]); move > 0)
      smallest = std::min(smallest, move);
  return smallest;
}

Columns columns_of(const Dataset& dataset, bool (*is_wanted)(std::string_view)) {
  Columns columns;
  for (std::size_t c = 0; c < dataset.columns.size(); ++c)
    if (is_wanted(without_robot(dataset.columns[c].channel.symbol))) columns.push_back(c);
  return columns;
}

// Of the commanded coordinates, in the order of the rows.
std::vector<Turn> turns_among(const Dataset& dataset, const Columns& commanded) {
  const auto move = [&](std::size_t c, std::size_t row) {
    const auto& values = dataset.columns[c].values;
    return values[row] - values[row - 1];
  };
  std::vector<double> half_move(dataset.columns.size());
  for (const std::size_t c : commanded) half_move[c] = smallest_move(dataset.columns[c].values) / 2;
  std::vector<Turn> turns;
  for (std::size_t row = 2; row + 1 < dataset.rows; ++row) {
    if (!std::ranges::all_of(commanded, [&](std::size_t c) { return move(c, row) == 0; })) continue;
    for (const std::size_t c : commanded) {
      const double before = move(c, row - 1), after = move(c, row + 1);
      if (!(before * after < 0)) continue;
      turns.push_back({row, c, row - 1, half_move[c] / std::abs(before)});
    }
  }
  return turns;
}

struct Turns {
  std::vector<Turn> commanded;
  Columns measured;  // coordinates that go along
};

// Motors say where a machine was sent. Where they are what was measured they hardly ever repeat a
// place, and the nominal pose does; it also does where there are no motors.
Turns turns_of(const Dataset& dataset) {
  const Columns motors = columns_of(dataset, is_motor_symbol);
  const Columns poses = columns_of(dataset, is_pose_symbol);
  auto of_motors = turns_among(dataset, motors), of_pose = turns_among(dataset, poses);
  if (of_motors.size() >= of_pose.size()) return {std::move(of_motors), poses};
  return {std::move(of_pose), motors};
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
    start.push_back({0, turn.column, static_cast<std::size_t>(moved - values.begin()),
                     -smallest_move(values) / 2 / std::abs(*moved - values[0])});
  }
  turns.insert(turns.begin(), start.begin(), start.end());
  return turns;
}

// Each column copied once, with the rows that are repeated twice.
template <class Value>
void take_rows(std::vector<Value>& values, const std::vector<std::size_t>& rows) {
  if (values.empty()) return;
  std::vector<Value> taken;
  taken.reserve(rows.size());
  for (const std::size_t row : rows) taken.push_back(values[row]);
  values = std::move(taken);
}

}  // namespace

bool says_overruns(const Dataset& dataset) {
  return std::ranges::any_of(dataset.metadata, [](const auto& line) {
    return line.first == kOverruns && line.second == "yes";
  });
}

std::vector<std::size_t> rows_after_overruns(const Dataset& dataset) {
  std::vector<std::size_t> rows;
  for (const Turn& turn : turns_of(dataset).commanded)
    if (rows.empty() || rows.back() != turn.row) rows.push_back(turn.row);
  return rows;
}

WholePath with_overruns(const Dataset& dataset) {
  const auto [commanded, measured] = turns_of(dataset);
  const auto turns = with_the_start(commanded, dataset);
  WholePath whole{dataset, {}};
  std::vector<std::size_t> rows;   // of the dataset, in the order of the path
  std::vector<std::size_t> added;  // place of each turn's further row among them
  auto turn = turns.begin();
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (turn != turns.end() && turn->row == row) {
      for (; turn != turns.end() && turn->row == row; ++turn) added.push_back(rows.size());
      rows.push_back(row);
    }
    whole.kept.push_back(rows.size());
    rows.push_back(row);
  }
  auto& data = whole.data;
  data.rows = rows.size();
  take_rows(data.time_s, rows), take_rows(data.set, rows), take_rows(data.line, rows);
  take_rows(data.zero, rows), take_rows(data.dwell_s, rows), take_rows(data.run, rows);
  take_rows(data.datum, rows), take_rows(data.excluded, rows);
  for (auto& column : data.columns) take_rows(column.values, rows);
  const auto further_on = [&](std::size_t column, std::size_t i) {
    const auto& values = dataset.columns[column].values;
    data.columns[column].values[added[i]] =
        values[turns[i].row] +
        turns[i].part * (values[turns[i].along] - values[turns[i].along - 1]);
  };
  // Of several turns in one row the measured coordinates follow the last.
  for (std::size_t i = 0; i < added.size(); ++i)
    for (const std::size_t c : measured) further_on(c, i);
  for (std::size_t i = 0; i < added.size(); ++i) further_on(turns[i].column, i);
  return whole;
}

}  // namespace driftwise
