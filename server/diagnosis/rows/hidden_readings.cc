#include "server/diagnosis/rows/hidden_readings.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kWorthKeeping = 0.1;  // of the variance of noise
constexpr double kErrors = 2;          // standard errors by which a coefficient is less
constexpr std::size_t kRowsPerColumn = 10;

// True: it reads this channel, and its value at a row is that of its channels at that row.
bool reads_at_the_row(const effects::Term& term, const std::string& symbol) {
  bool reads = false;
  for (const auto& factor : term.factors) {
    const auto* power = std::get_if<effects::Power>(&factor);
    if (power == nullptr) return false;
    reads = reads || power->symbol == symbol;
  }
  return reads;
}

struct Fitted {
  Eigen::MatrixXd sure;   // terms x outputs: |coefficient| less its standard errors, at least 0
  Eigen::VectorXd noise;  // per output, from row to row
};

Fitted fitted(const Problem& problem) {
  Eigen::MatrixXd x = rows_of(problem.base_columns, problem.learn);
  const Eigen::VectorXd inverse = x.colwise().norm().cwiseMax(1e-300).cwiseInverse().transpose();
  x = x * inverse.asDiagonal();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(x);
  const Eigen::Index p = x.cols();
  const Eigen::MatrixXd root =
      qr.matrixQR().topLeftCorner(p, p).triangularView<Eigen::Upper>().solve(
          Eigen::MatrixXd::Identity(p, p));
  const Eigen::VectorXd error = inverse.cwiseProduct(root.rowwise().norm());
  const auto outputs = static_cast<Eigen::Index>(problem.outputs.size());
  Fitted result{Eigen::MatrixXd(p, outputs), Eigen::VectorXd(outputs)};
  for (Eigen::Index o = 0; o < outputs; ++o) {
    const Eigen::VectorXd y =
        rows_of(problem.outputs[static_cast<std::size_t>(o)].measured, problem.learn);
    const Eigen::VectorXd b = qr.solve(y);
    const Eigen::VectorXd left = y - x * b;
    const Eigen::Index pairs = left.size() - 1;
    result.noise[o] =
        (left.tail(pairs) - left.head(pairs)).norm() / std::sqrt(2 * static_cast<double>(pairs));
    result.sure.col(o) =
        (inverse.cwiseProduct(b).cwiseAbs() - kErrors * result.noise[o] * error).cwiseMax(0.0);
  }
  return result;
}

}  // namespace

Result<Hidden> hidden_in(const Problem& problem) {
  if (problem.prepared.coarse().empty()) return Hidden{};
  const auto [sure, noise] = fitted(problem);
  struct One {
    Eigen::VectorXd column, sd;
    double beyond_noise = 0;
  };
  std::vector<One> found;
  for (const auto& [symbol, channel] : problem.prepared.coarse()) {
    const auto values = problem.prepared.conditions().values_of(symbol);
    Prepared further = problem.prepared;
    std::vector<double> shifted(values.begin(), values.end());
    for (double& value : shifted) value += channel.step;
    further.set_coordinate(symbol, shifted);
    for (std::size_t t = 0; t < problem.base.size(); ++t) {
      const Eigen::VectorXd sd = sure.row(static_cast<Eigen::Index>(t)).transpose();
      if (!reads_at_the_row(problem.base[t], symbol) || !(sd.maxCoeff() > 0)) continue;
      DRIFTWISE_TRY(const auto at, problem.prepared.columns({problem.base[t]}));
      DRIFTWISE_TRY(const auto beyond, further.columns({problem.base[t]}));
      const Eigen::VectorXd per_unit = (beyond - at).col(0) / channel.step;
      for (Eigen::Index k = 0; k < channel.unsure.cols(); ++k) {
        Eigen::VectorXd column = per_unit.cwiseProduct(channel.unsure.col(k));
        const double variance = (sd * rows_of(column, problem.learn).norm())
                                    .cwiseQuotient(noise)
                                    .cwiseAbs2()
                                    .maxCoeff();
        if (variance > kWorthKeeping) found.push_back({std::move(column), sd, variance});
      }
    }
  }
  std::ranges::stable_sort(found, std::ranges::greater{}, &One::beyond_noise);
  found.resize(std::min(found.size(), problem.learn.size() / kRowsPerColumn));
  const auto count = static_cast<Eigen::Index>(found.size());
  Hidden result{Eigen::MatrixXd(problem.base_columns.rows(), count),
                Eigen::MatrixXd(count, noise.size())};
  for (Eigen::Index k = 0; k < count; ++k) {
    result.columns.col(k) = found[static_cast<std::size_t>(k)].column;
    result.sd.row(k) = found[static_cast<std::size_t>(k)].sd.transpose();
  }
  return result;
}

}  // namespace driftwise::diagnosis
