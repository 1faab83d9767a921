#include "server/diagnosis/separating/separating_power.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>

#include "server/calibration/design/predict.h"
#include "server/core/try.h"
#include "server/diagnosis/noise/noise_model.h"

namespace driftwise::diagnosis {
namespace {

// What each cell of each hypothesis predicts: all outputs one below the other, whitened, in units
// of the white noise, freed of what the simulation's own terms could take up.
struct Predicted {
  std::vector<Eigen::MatrixXd> of;  // per hypothesis: (rows x outputs) x cells
};

Timeline timeline_of(const Dataset& rows) {
  Timeline timeline;
  timeline.time_s =
      Eigen::Map<const Eigen::VectorXd>(rows.time_s.data(), static_cast<Eigen::Index>(rows.rows));
  timeline.restart.assign(rows.rows, 0);
  if (!timeline.restart.empty()) timeline.restart.front() = 1;
  return timeline;
}

Result<Predicted> predicted(const Dataset& rows, const std::vector<effects::Term>& base,
                            const std::vector<Hypothesis>& hypotheses,
                            const std::vector<OutputSummary>& outputs) {
  const auto n = static_cast<Eigen::Index>(rows.rows);
  DRIFTWISE_TRY(const auto base_columns, calibration::raw_columns(rows, base));
  const Timeline timeline = timeline_of(rows);
  std::vector<Eigen::MatrixXd> columns;  // of every cell
  Predicted out;
  for (const auto& hypothesis : hypotheses) {
    auto& all = out.of.emplace_back(n * static_cast<Eigen::Index>(outputs.size()),
                                    static_cast<Eigen::Index>(hypothesis.cells.size()));
    for (std::size_t c = 0; c < hypothesis.cells.size(); ++c) {
      const auto& cell = hypothesis.cells[c];
      DRIFTWISE_TRY(const auto raw, calibration::raw_columns(rows, cell.terms));
      for (std::size_t o = 0; o < outputs.size(); ++o)
        all.col(static_cast<Eigen::Index>(c)).segment(static_cast<Eigen::Index>(o) * n, n) =
            raw * cell.coefficients.col(static_cast<Eigen::Index>(o));
    }
  }
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const Whitener whitener(timeline, noise_of(outputs[o]));
    Eigen::MatrixXd taken_up(n, base_columns.cols() + 1);
    taken_up << Eigen::VectorXd::Ones(n), base_columns;
    whitener.apply(taken_up);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(taken_up);
    const double sd = outputs[o].noise_white_sd > 0 ? outputs[o].noise_white_sd : 1;
    for (auto& all : out.of) {
      Eigen::MatrixXd part = all.middleRows(static_cast<Eigen::Index>(o) * n, n);
      whitener.apply(part);
      all.middleRows(static_cast<Eigen::Index>(o) * n, n) = (part - taken_up * qr.solve(part)) / sd;
    }
  }
  return out;
}

// Squared distance from y to the nearest cell.
double nearest(const Eigen::VectorXd& y, const Eigen::MatrixXd& cells) {
  return (cells.colwise() - y).colwise().squaredNorm().minCoeff();
}

// Classes from the distances between hypotheses; fills everything but the power.
SeparatingPower classified(const Predicted& all) {
  const std::size_t count = all.of.size();
  SeparatingPower result;
  Eigen::MatrixXd apart(count, count);
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < count; ++b)
      apart(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) =
          nearest(all.of[a].col(0), all.of[b]);
  apart = apart.cwiseMin(apart.transpose()).eval();
  for (std::size_t i = 0; i < count; ++i) result.class_of.push_back(i);
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const std::size_t from = result.class_of[a], to = result.class_of[b];
      if (apart(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) <= kIdentifiable2lnl)
        std::ranges::replace(result.class_of, std::max(from, to), std::min(from, to));
    }
  // Numbered without gaps: each class still has the number of its first member.
  for (std::size_t i = 0; i < count; ++i)
    if (result.class_of[i] == i) std::ranges::replace(result.class_of, i, result.classes++);
  double widest = 0, nearest_other = 1e300;
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const double pair = apart(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
      widest = std::max(widest, pair);
      if (result.class_of[a] != result.class_of[b]) nearest_other = std::min(nearest_other, pair);
    }
  result.expected_2lnl = result.classes > 1 ? nearest_other : widest;
  return result;
}

}  // namespace

Result<SeparatingPower> separating_power(const Dataset& rows,
                                         const std::vector<effects::Term>& base,
                                         const std::vector<Hypothesis>& hypotheses,
                                         const std::vector<OutputSummary>& outputs, int simulations,
                                         std::uint64_t seed) {
  DRIFTWISE_TRY(const auto all, predicted(rows, base, hypotheses, outputs));
  SeparatingPower result = classified(all);
  if (simulations == 0 || result.classes < 2) return result;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> gaussian;
  result.power = 1;
  for (std::size_t truth = 0; truth < hypotheses.size(); ++truth) {
    const Eigen::VectorXd signal = all.of[truth].col(0);
    int ahead = 0;
    for (int k = 0; k < simulations; ++k) {
      Eigen::VectorXd y = signal;
      for (Eigen::Index i = 0; i < y.size(); ++i) y[i] += gaussian(random);
      double own = 1e300, others = 1e300;
      for (std::size_t h = 0; h < hypotheses.size(); ++h) {
        double& side = result.class_of[h] == result.class_of[truth] ? own : others;
        side = std::min(side, nearest(y, all.of[h]));
      }
      ahead += others - own > kAhead2lnl ? 1 : 0;
    }
    result.power = std::min(result.power, static_cast<double>(ahead) / simulations);
  }
  return result;
}

}  // namespace driftwise::diagnosis
