#include "server/diagnosis/path_of_turns.h"

#include <Eigen/QR>
#include <Eigen/Sparse>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "server/core/data/overruns.h"
#include "server/core/try.h"

namespace driftwise::diagnosis {
namespace {

// 2 ln of the likelihoods' ratio: of noise alone 1 in 600.
constexpr double kFarLess = 10;
constexpr double kWidth_nm = 0.1, kWidth_arcsec = 1e-4;  // of a play that every move takes up

// Sides of every motor: what a play narrower than any move leaves behind. Rows that learn.
Result<Eigen::MatrixXd> sides(const Problem& problem) {
  std::vector<effects::Term> plays;
  for (const auto& column : problem.prepared.path().columns) {
    const auto& [symbol, unit] = column.channel;
    if (!is_motor_symbol(symbol)) continue;
    const effects::Quantity width = unit == "mm" ? effects::Quantity{kWidth_nm, "nm"}
                                                 : effects::Quantity{kWidth_arcsec, "arcsec"};
    plays.push_back({{effects::Call{"play", {symbol}, {width}}}});
  }
  DRIFTWISE_TRY(const auto columns, problem.prepared.columns(plays));
  return Eigen::MatrixXd(rows_of(columns, problem.learn));
}

// Correlations of the errors of neighbouring rows that are tried: a room that drifts is no play.
constexpr std::array<double, 7> kCorrelations = {0, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99};

// Independent rows of errors with this correlation from row to row.
Eigen::MatrixXd whitened(const Eigen::MatrixXd& values, double correlation) {
  Eigen::MatrixXd white = values;
  const Eigen::Index later = values.rows() - 1;
  white.bottomRows(later) -= correlation * values.topRows(later);
  white.row(0) *= std::sqrt(1 - correlation * correlation);
  return white;
}

// A level for each place of all motors, so that nothing that goes with the place hides a play. None
// where most rows have a place of their own.
class Places {
 public:
  explicit Places(const Problem& problem) {
    std::map<std::vector<double>, Eigen::Index> numbers;
    for (const std::size_t row : problem.learn) {
      std::vector<double> place;
      for (const auto& column : problem.prepared.path().columns)
        if (is_motor_symbol(column.channel.symbol)) place.push_back(column.values[row]);
      place_of_.push_back(
          numbers.emplace(std::move(place), static_cast<Eigen::Index>(numbers.size()))
              .first->second);
    }
    places_ = std::ssize(numbers);
  }

  // Whitened columns, less what the levels explain.
  Eigen::MatrixXd beyond(const Eigen::MatrixXd& white, double correlation) const {
    if (2 * places_ > white.rows()) return white;
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index i = 0; i < white.rows(); ++i) {
      const double own = i > 0 ? 1 : std::sqrt(1 - correlation * correlation);
      entries.emplace_back(i, place_of_[static_cast<std::size_t>(i)], own);
      if (i > 0) entries.emplace_back(i, place_of_[static_cast<std::size_t>(i - 1)], -correlation);
    }
    Eigen::SparseMatrix<double> levels(white.rows(), places_);
    levels.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SparseMatrix<double> gram = levels.transpose() * levels;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(gram);
    return white - levels * solver.solve(levels.transpose() * white);
  }

 private:
  std::vector<Eigen::Index> place_of_;
  Eigen::Index places_ = 0;
};

double two_ln_likelihood(const Problem& problem, const Places& places,
                         const Eigen::MatrixXd& further) {
  const Eigen::MatrixXd base = rows_of(problem.base_columns, problem.learn);
  const auto outputs = std::ssize(problem.outputs);
  Eigen::MatrixXd all(base.rows(), base.cols() + further.cols() + outputs);
  all.leftCols(base.cols() + further.cols()) << base, further;
  for (Eigen::Index o = 0; o < outputs; ++o)
    all.col(all.cols() - outputs + o) =
        rows_of(problem.outputs[static_cast<std::size_t>(o)].measured, problem.learn);
  const Eigen::RowVectorXd lengths = all.colwise().norm().cwiseMax(1e-300);
  all = all * lengths.cwiseInverse().asDiagonal();
  const auto rows = static_cast<double>(all.rows());
  Eigen::VectorXd most = Eigen::VectorXd::Constant(outputs, -INFINITY);
  for (const double correlation : kCorrelations) {
    const Eigen::MatrixXd white = places.beyond(whitened(all, correlation), correlation);
    const Eigen::MatrixXd measured = white.rightCols(outputs),
                          columns = white.leftCols(white.cols() - outputs);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
    const Eigen::RowVectorXd left =
        (measured - columns * qr.solve(measured)).colwise().squaredNorm().cwiseMax(1e-300);
    most = most.cwiseMax(
        (std::log(1 - correlation * correlation) - rows * left.array().log()).matrix().transpose());
  }
  return most.sum();
}

std::string overruns_sentence(std::size_t count, const std::string& first_row) {
  return std::to_string(count) + " rows (the first is " + first_row +
         ") repeat a target where the axis turns, and read as if it had gone past the target in "
         "between, as ISO 230-2 has it: they count as reached from the other side. For a fit, "
         "write "
         "\"# overruns: yes\" at the head of the file";
}

}  // namespace

Result<Problem> lay_out_on_path(Dataset& data, const DiagnoseOptions& options, std::size_t longest,
                                Judging judging, std::vector<std::string>& sentences) {
  DRIFTWISE_TRY(auto problem, lay_out(data, options.baseline, longest, judging));
  if (data.time_s.empty() || says_overruns(data)) return problem;
  const auto rows = rows_after_overruns(data);
  if (rows.empty()) return problem;
  const auto plain = sides(problem);
  Dataset with = data;
  with.metadata.emplace_back(kOverruns, "yes");
  DRIFTWISE_TRY(auto overrunning, lay_out(with, options.baseline, longest, judging));
  const auto overrun = sides(overrunning);
  if (!plain || !overrun || plain->cols() == 0 || !plain->allFinite() || !overrun->allFinite())
    return problem;
  const Places places(problem);
  if (two_ln_likelihood(problem, places, *overrun) <
      two_ln_likelihood(problem, places, *plain) + kFarLess)
    return problem;
  sentences.push_back(overruns_sentence(rows.size(), options.name_of_row(rows.front())));
  data = std::move(with);
  return overrunning;
}

}  // namespace driftwise::diagnosis
