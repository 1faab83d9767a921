#include "server/diagnosis/search/column_bank.h"

#include <algorithm>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/diagnosis/search/wave_columns.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kOneColumn = 1e-7;        // of 1 - R^2
constexpr std::size_t kNumbers = 4 << 20;  // evaluated at a time: 32 MB

void fill(Eigen::MatrixXd& columns) {
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    if (columns.col(j).allFinite()) continue;
    double sum = 0, count = 0;
    for (Eigen::Index i = 0; i < columns.rows(); ++i)
      if (std::isfinite(columns(i, j))) sum += columns(i, j), count += 1;
    const double mean = count > 0 ? sum / count : 0;
    for (Eigen::Index i = 0; i < columns.rows(); ++i)
      if (!std::isfinite(columns(i, j))) columns(i, j) = mean;
  }
}

// The simulation's column of one factor alone; negative: it has none.
Eigen::Index alone_in(const std::vector<effects::Term>& base, const effects::Factor& factor) {
  const effects::Term alone{{factor}};
  const auto at = std::ranges::find(base, alone);
  return at == base.end() ? -1 : static_cast<Eigen::Index>(at - base.begin());
}

double learned_mean(const Problem& problem, const Eigen::VectorXd& column) {
  double sum = 0, count = 0;
  for (const std::size_t row : problem.learn)
    if (const double value = column[static_cast<Eigen::Index>(row)]; std::isfinite(value))
      sum += value, count += 1;
  return count > 0 ? sum / count : 0;
}

// Products less what the simulation has of them already: x * t01 about the mean temperature, where
// x is simulated. The simulation with the column is the same; a length of the column is one of the
// effect, not of 20 degC times x.
Result<void> beyond_the_factors(const Problem& problem, const std::vector<effects::Term>& terms,
                                Eigen::MatrixXd& columns) {
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const auto& factors = terms[k].factors;
    if (factors.size() != 2) continue;
    for (std::size_t f = 0; f < 2; ++f) {
      const Eigen::Index simulated = alone_in(problem.base, factors[f]);
      if (simulated < 0) continue;
      DRIFTWISE_TRY(const auto other, problem.prepared.columns({effects::Term{{factors[1 - f]}}}));
      columns.col(static_cast<Eigen::Index>(k)) -=
          learned_mean(problem, other.col(0)) * problem.base_columns.col(simulated);
    }
  }
  return {};
}

bool same(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.cols() != 1 || b.cols() != 1) return false;
  const Eigen::VectorXd u = a.col(0).array() - a.mean(), v = b.col(0).array() - b.mean();
  const double scale = u.norm() * v.norm();
  return scale > 0 && 1 - std::pow(u.dot(v) / scale, 2) < kOneColumn;
}

// Which parameters of which cells: the columns of some cells, one row per block.
Result<std::vector<Eigen::MatrixXd>> columns_of(const Problem& problem,
                                                std::span<const Cell> cells) {
  std::vector<effects::Term> terms;
  for (const auto& cell : cells) terms.insert(terms.end(), cell.terms.begin(), cell.terms.end());
  DRIFTWISE_TRY(const auto all, searched_columns(problem, terms));
  const Eigen::MatrixXd learned = problem.learned(all);
  std::vector<Eigen::MatrixXd> result;
  Eigen::Index at = 0;
  for (const auto& cell : cells) {
    result.emplace_back(learned.middleCols(at, static_cast<Eigen::Index>(cell.terms.size())));
    at += static_cast<Eigen::Index>(cell.terms.size());
  }
  return result;
}

}  // namespace

Result<Eigen::MatrixXd> filled_columns(const Problem& problem,
                                       const std::vector<effects::Term>& terms) {
  auto columns = problem.prepared.columns(terms);
  if (columns) fill(*columns);
  return columns;
}

Result<Eigen::MatrixXd> searched_columns(const Problem& problem,
                                         const std::vector<effects::Term>& terms) {
  DRIFTWISE_TRY(auto columns, problem.prepared.columns(terms));
  DRIFTWISE_RETURN_IF_ERROR(beyond_the_factors(problem, terms, columns));
  fill(columns);
  return columns;
}

std::vector<char> acts_on(const Problem& problem, const Cause& cause) {
  std::vector<char> on;
  for (const auto& output : problem.outputs) on.push_back(may_act_on(cause, output.channel.symbol));
  return on;
}

Result<Bank> column_bank(const Problem& problem, const Physics& physics, std::vector<Cause>& causes,
                         const std::function<bool()>& tick) {
  Bank bank;
  std::erase_if(causes, [&](const Cause& cause) {
    return std::ranges::count(acts_on(problem, cause), 1) == 0;
  });
  Eigen::Index most = 0, width = 0;
  for (const auto& cause : causes)
    for (const auto& cell : cause.cells) most += static_cast<Eigen::Index>(cell.terms.size());
  bank.columns.resize(problem.timeline.rows(), most);
  const auto keep = [&](const auto& columns) {
    bank.cells.push_back({width, columns.cols()});
    bank.columns.middleCols(width, columns.cols()) = columns;
    width += columns.cols();
  };
  const std::size_t at_once = std::max<std::size_t>(1, kNumbers / problem.data().rows / 2);
  for (auto& cause : causes) {
    const std::size_t first = bank.cells.size();
    if (tick && !tick()) return fail(ErrorCode::cancelled, reasons::kCancelled, "it was cancelled");
    if (const auto waves = wave_columns(problem, cause, tick)) {
      for (Eigen::Index c = 0; c < waves->cols() / 2; ++c) keep(waves->middleCols(2 * c, 2));
    } else {
      std::vector<Cell> kept;
      for (std::size_t begin = 0; begin < cause.cells.size(); begin += at_once) {
        if (tick && !tick())
          return fail(ErrorCode::cancelled, reasons::kCancelled, "it was cancelled");
        const std::size_t count = std::min(at_once, cause.cells.size() - begin);
        DRIFTWISE_TRY(const auto columns,
                      columns_of(problem, std::span(cause.cells).subspan(begin, count)));
        for (std::size_t i = 0; i < count; ++i) {
          if (!kept.empty() && cause.scale == ParameterScale::logarithmic &&
              same(bank.columns.middleCols(bank.cells.back().first, bank.cells.back().count),
                   columns[i]))
            continue;
          kept.push_back(std::move(cause.cells[begin + i]));
          keep(columns[i]);
        }
      }
      cause.cells = std::move(kept);
    }
    bank.entries.push_back({first, bank.cells.size() - first});
    double sum = 0;
    for (const auto& cell : cause.cells) sum += cell.weight;
    for (const auto& cell : cause.cells) bank.ln_weight.push_back(std::log(cell.weight / sum));
  }
  bank.columns.conservativeResize(Eigen::NoChange, width);
  bank.prior.resize(width, static_cast<Eigen::Index>(problem.outputs.size()));
  for (std::size_t e = 0; e < causes.size(); ++e)
    for (std::size_t c = 0; c < bank.entries[e].count; ++c) {
      const auto& at = bank.cells[bank.entries[e].first + c];
      const auto& cell = causes[e].cells[c];
      bank.prior.middleRows(at.first, at.count) =
          physics
              .prior(causes[e], cell.terms, cell.parameter,
                     bank.columns.middleCols(at.first, at.count))
              .typical;
    }
  return bank;
}

}  // namespace driftwise::diagnosis
