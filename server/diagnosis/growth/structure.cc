#include "server/diagnosis/growth/structure.h"

#include <algorithm>
#include <cmath>

#include "server/diagnosis/rows/places.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kKnots = 13, kKnotsOfProducts = 5, kMostPlaces = 20;

// Hat functions between neighbouring quantiles; no columns for fewer than 4 different ones.
Eigen::MatrixXd hats(const Eigen::VectorXd& values, std::size_t most) {
  std::vector<double> sorted(values.data(), values.data() + values.size());
  std::ranges::sort(sorted);
  std::vector<double> knots;
  const double apart = (sorted.back() - sorted.front()) / (4 * static_cast<double>(most));
  std::vector<double> places = by_places(sorted);  // few of them: each its own knot
  places.erase(std::ranges::unique(places).begin(), places.end());
  if (most == kKnots && places.size() <= kMostPlaces)
    knots = std::move(places);
  else
    for (std::size_t k = 0; k < most; ++k) {
      const double at = sorted[k * (sorted.size() - 1) / (most - 1)];
      if (knots.empty() || at > knots.back() + apart) knots.push_back(at);
    }
  if (knots.size() < 4) return {};
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(values.size(), static_cast<Eigen::Index>(knots.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const auto above = std::ranges::upper_bound(knots, values[i]);
    const auto right = std::clamp<std::ptrdiff_t>(above - knots.begin(), 1,
                                                  static_cast<std::ptrdiff_t>(knots.size()) - 1);
    const auto r = static_cast<std::size_t>(right);
    const double share =
        std::clamp((values[i] - knots[r - 1]) / (knots[r] - knots[r - 1]), 0.0, 1.0);
    columns(i, right - 1) = 1 - share;
    columns(i, right) = share;
  }
  return columns;
}

struct Variable {
  std::string name;
  Eigen::VectorXd values;  // at the blocks
  bool axis = false;
};

std::vector<Variable> variables_of(const Problem& problem,
                                   const std::vector<std::string>& excluded) {
  const Dataset& data = problem.prepared.conditions();
  const auto outputs = problem.output_symbols();
  std::vector<Variable> variables;
  const auto add = [&](const std::string& name, const std::vector<double>& values, bool axis) {
    if (values.empty() || std::ranges::find(excluded, name) != excluded.end()) return;
    const Eigen::Map<const Eigen::VectorXd> all(values.data(),
                                                static_cast<Eigen::Index>(values.size()));
    Eigen::VectorXd taken = problem.learned(all);
    if (!taken.allFinite() || !(taken.maxCoeff() > taken.minCoeff())) return;
    variables.push_back({name, std::move(taken), axis});
  };
  for (const auto& column : data.columns) {
    const auto& symbol = column.channel.symbol;
    if (is_motor_symbol(symbol) || is_response(column.channel, outputs) ||
        symbol.ends_with("_std") || symbol.ends_with("_cmd") || symbol.ends_with("_target"))
      continue;
    add(symbol, column.values, is_coordinate(problem, column.channel));
  }
  add("dwell", data.dwell_s, false);
  add("time", problem.data().time_s, false);
  return variables;
}

}  // namespace

FreeShapes free_shapes(const Problem& problem, const Physics& physics,
                       const std::vector<std::string>& excluded) {
  FreeShapes shapes;
  std::vector<Eigen::MatrixXd> parts;
  Eigen::Index width = 0;
  const auto add = [&](const std::string& name, Eigen::MatrixXd columns) {
    if (columns.cols() == 0) return;
    shapes.variables.push_back(name);
    shapes.bank.entries.push_back({shapes.bank.cells.size(), 1});
    shapes.bank.ln_weight.push_back(0);
    shapes.bank.cells.push_back({width, columns.cols()});
    width += columns.cols();
    parts.push_back(std::move(columns));
  };
  const auto variables = variables_of(problem, excluded);
  for (const auto& v : variables) add(v.name, hats(v.values, kKnots));
  for (const auto& axis : variables) {
    if (!axis.axis) continue;
    const Eigen::VectorXd centred = axis.values.array() - axis.values.mean();
    for (const auto& v : variables) {
      if (v.name == axis.name) continue;
      Eigen::MatrixXd columns = hats(v.values, kKnotsOfProducts);
      for (Eigen::Index j = 0; j < columns.cols(); ++j) columns.col(j).array() *= centred.array();
      add(axis.name + " with " + v.name, std::move(columns));
    }
  }
  shapes.bank.columns.resize(problem.timeline.rows(), width);
  for (std::size_t i = 0; i < parts.size(); ++i)
    shapes.bank.columns.middleCols(shapes.bank.cells[i].first, shapes.bank.cells[i].count) =
        parts[i];
  shapes.bank.prior = physics.of_free_shape(shapes.bank.columns);
  return shapes;
}

}  // namespace driftwise::diagnosis
