// The dictionary of the test that knows no cause.

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/growth/omnibus.h"
#include "server/diagnosis/rows/motor_places.h"

namespace driftwise::diagnosis {
namespace {

constexpr Eigen::Index kMostWaves = 127, kRowsPerWave = 4;
constexpr int kAxisWaves = 8, kPairWaves = 3, kTripleWaves = 2, kConditionWaves = 3;
constexpr int kSmoothWaves = 3, kMemoryWaves = 2;

Eigen::VectorXf wave(const Eigen::VectorXd& u, int k) {
  return (std::numbers::sqrt2 * (std::numbers::pi * k * u.array()).cos()).cast<float>();
}

void append(Eigen::MatrixXf& columns, const Eigen::VectorXf& column) {
  columns.conservativeResize(column.size(), columns.cols() + 1);
  columns.col(columns.cols() - 1) = column;
}

}  // namespace

Eigen::VectorXd unit_range(const Eigen::VectorXd& values) {
  if (!values.allFinite()) return {};
  const double low = values.minCoeff(), high = values.maxCoeff();
  if (!(high > low + 1e-12 * std::abs(high))) return {};
  return (values.array() - low) / (high - low);
}

Omnibus::Omnibus(const Problem& problem, const Eigen::MatrixXd& series,
                 const std::vector<std::string>& excluded)
    : problem_(problem), series_(series) {
  const Eigen::Index n = problem.timeline.rows();
  const Eigen::Index waves = std::clamp<Eigen::Index>(n / kRowsPerWave, 1, kMostWaves);
  Eigen::VectorXd order(n);
  for (Eigen::Index i = 0; i < n; ++i)
    order[i] = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
  time_waves_.resize(n, waves);
  time_waves_.col(0).setOnes();
  for (Eigen::Index k = 1; k < waves; ++k) time_waves_.col(k) = wave(order, static_cast<int>(k));
  bands_.push_back({0, 1, "throughout"});
  for (Eigen::Index first = 1; first < waves; first = 2 * first + 1) {
    const Eigen::Index count = std::min(first + 1, waves - first);
    bands_.push_back({first, count, first < 3 ? "slowly with time" : "with time"});
  }
  add_groups(excluded);
  add_lines();
}

// As the plan numbers them. Level, first row, and a decay over three rows.
void Omnibus::add_lines() {
  constexpr std::size_t kFewestLines = 4, kFewestRows = 3;
  const auto& line = problem_.prepared.conditions().line;
  const Eigen::Index n = problem_.timeline.rows();
  if (line.empty() || problem_.rows_per_block > 1) return;
  const Eigen::VectorXd number =
      problem_.learned(Eigen::Map<const Eigen::Array<std::int64_t, Eigen::Dynamic, 1>>(
                           line.data(), static_cast<Eigen::Index>(line.size()))
                           .cast<double>()
                           .matrix());
  for (Eigen::Index i = 0; i < n; ++i) {
    if (problem_.timeline.restart[static_cast<std::size_t>(i)] != 0 || number[i] != number[i - 1])
      lines_.emplace_back(i, 0);
    ++lines_.back().second;
  }
  if (lines_.size() < kFewestLines || static_cast<std::size_t>(n) < kFewestRows * lines_.size()) {
    lines_.clear();
    return;
  }
  line_waves_ = Eigen::MatrixXf::Ones(n, 3);
  for (const auto& [first, count] : lines_)
    for (Eigen::Index i = 0; i < count; ++i) {
      line_waves_(first + i, 1) = i == 0 ? 1 : 0;
      line_waves_(first + i, 2) = std::exp(-static_cast<float>(i) / 3);
    }
}

void Omnibus::add_groups(const std::vector<std::string>& excluded) {
  const Eigen::Index n = problem_.timeline.rows();
  const Dataset& data = problem_.prepared.conditions();
  const auto outputs = problem_.output_symbols();
  const auto add = [&](Group group) {
    if (group.waves.cols() > 0) groups_.push_back(std::move(group));
  };
  add({"every row", Eigen::MatrixXf::Ones(n, 1), {}});
  struct Axis {
    std::string name;
    Eigen::VectorXd u;
  };
  std::vector<Axis> axes;
  std::vector<Eigen::VectorXd> temperatures, directions;
  std::vector<std::string> direction_of;
  const auto learned = [&](const std::vector<double>& values) {
    return Eigen::VectorXd(problem_.learned(Eigen::Map<const Eigen::VectorXd>(
        values.data(), static_cast<Eigen::Index>(values.size()))));
  };
  bool any_pose = false;
  for (const auto& column : data.columns)
    any_pose =
        any_pose || (is_pose_symbol(column.channel.symbol) && is_length(column.channel.unit) &&
                     unit_range(learned(column.values)).size() > 0);
  for (const auto& column : data.columns) {
    const auto& symbol = column.channel.symbol;
    if (std::ranges::find(excluded, symbol) != excluded.end()) continue;
    if (is_response(column.channel, outputs)) continue;
    Eigen::VectorXd values = learned(column.values);
    const Eigen::VectorXd u = unit_range(values);
    if (u.size() == 0) continue;
    if (is_motor_symbol(symbol)) {
      if (!any_pose) axes.push_back({symbol, u});
      Eigen::VectorXd direction = Eigen::VectorXd::Zero(n);
      for (Eigen::Index i = 1; i < n; ++i)
        direction[i] =
            std::abs(u[i] - u[i - 1]) > 1e-3 ? (u[i] > u[i - 1] ? 1 : -1) : direction[i - 1];
      directions.push_back(std::move(direction));
      direction_of.push_back(symbol);
    } else if (is_pose_symbol(symbol) && is_length(column.channel.unit)) {
      axes.push_back({symbol, u});
    } else if (is_structure_temperature(column.channel)) {
      temperatures.push_back((values.array() - values.mean()) /
                             std::sqrt((values.array() - values.mean()).square().mean()));
    } else if (!symbol.ends_with("_std") && !symbol.ends_with("_cmd")) {
      Group group{symbol, {}, {symbol}};
      for (int k = 1; k <= kConditionWaves; ++k) append(group.waves, wave(u, k));
      add(std::move(group));
    }
  }
  if (axes.size() > 3) axes.resize(3);
  for (const auto& axis : axes) {
    Group group{axis.name, {}, {axis.name}};
    for (int k = 1; k <= kAxisWaves; ++k) append(group.waves, wave(axis.u, k));
    add(std::move(group));
  }
  for (std::size_t a = 0; a < axes.size(); ++a)
    for (std::size_t b = a + 1; b < axes.size(); ++b) {
      Group group{axes[a].name + " and " + axes[b].name, {}, {axes[a].name, axes[b].name}};
      for (int k = 1; k <= kPairWaves; ++k)
        for (int l = 1; l <= kPairWaves; ++l)
          append(group.waves, wave(axes[a].u, k).cwiseProduct(wave(axes[b].u, l)));
      add(std::move(group));
    }
  if (axes.size() == 3) {
    Group group{"x, y and z", {}, {axes[0].name, axes[1].name, axes[2].name}};
    for (int k = 1; k <= kTripleWaves; ++k)
      for (int l = 1; l <= kTripleWaves; ++l)
        for (int m = 1; m <= kTripleWaves; ++m)
          append(
              group.waves,
              wave(axes[0].u, k).cwiseProduct(wave(axes[1].u, l)).cwiseProduct(wave(axes[2].u, m)));
    add(std::move(group));
  }
  if (!temperatures.empty()) {
    Eigen::MatrixXd all(n, static_cast<Eigen::Index>(temperatures.size()));
    for (std::size_t t = 0; t < temperatures.size(); ++t)
      all.col(static_cast<Eigen::Index>(t)) = temperatures[t];
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(all.transpose() * all);
    Group group{"the temperatures", {}, {}};
    for (Eigen::Index c = 0; c < std::min<Eigen::Index>(2, all.cols()); ++c) {
      const Eigen::VectorXd u = unit_range(all * eigen.eigenvectors().col(all.cols() - 1 - c));
      for (int k = 1; u.size() > 0 && k <= kConditionWaves; ++k) append(group.waves, wave(u, k));
    }
    add(std::move(group));
  }
  if (!data.dwell_s.empty())
    if (const Eigen::VectorXd u = unit_range(learned(data.dwell_s)); u.size() > 0) {
      Group group{"the dwell", {}, {}};
      for (int k = 1; k <= 2; ++k) append(group.waves, wave(u, k));
      add(std::move(group));
    }
  for (std::size_t d = 0; d < directions.size(); ++d) {
    Group group{"the direction of " + direction_of[d], {}, {}};
    const Eigen::VectorXf sign = directions[d].cast<float>();
    append(group.waves, sign);
    for (const auto& axis : axes)
      for (int k = 1; k <= 2; ++k) append(group.waves, wave(axis.u, k).cwiseProduct(sign));
    add(std::move(group));
  }
  // Fields need narrow families: their growth pays for every column.
  fields_ = groups_;
  for (const auto& axis : axes) {
    Group smooth{axis.name, {}, {axis.name}}, memory{axis.name + " and the rows before", {}, {}};
    for (int k = 1; k <= kSmoothWaves; ++k) append(smooth.waves, wave(axis.u, k));
    for (Eigen::Index lag = 1; lag <= kLags && lag < n; ++lag) {
      Eigen::VectorXd before(n);
      before << axis.u.head(lag), axis.u.head(n - lag);
      for (int k = 1; k <= kMemoryWaves; ++k)
        for (int l = 1; l <= kMemoryWaves; ++l)
          append(memory.waves, wave(axis.u, k).cwiseProduct(wave(before, l)));
    }
    fields_.push_back(std::move(smooth));
    fields_.push_back(std::move(memory));
  }
  for (std::size_t d = 0; d < directions.size(); ++d)
    fields_.push_back({"the direction of " + direction_of[d], directions[d].cast<float>(), {}});
  auto places = motor_places(problem_);
  place_of_ = std::move(places.of_block);
  place_count_ = places.places.size();
  by_place_.clear();
  for (Eigen::Index i = 0; i < n && !place_of_.empty(); ++i) by_place_.push_back(i);
  // Neighbours along the coordinates, visits of one place in time order.
  std::ranges::stable_sort(by_place_, {}, [&](Eigen::Index i) {
    return places.places[place_of_[static_cast<std::size_t>(i)]];
  });
  if (place_count_ >= 4 && 2 * place_count_ <= static_cast<std::size_t>(n))
    groups_.push_back({"the place", {}, {}});
  else
    place_count_ = 0;
}

}  // namespace driftwise::diagnosis
