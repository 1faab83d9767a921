#include "server/diagnosis/path_of_turns.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>

#include "server/calibration/design/predict.h"
#include "server/core/data/overruns.h"
#include "server/core/try.h"

namespace driftwise::diagnosis {
namespace {

// 2 ln of the likelihoods' ratio, of independent rows: of noise alone 1 in 600.
constexpr double kFarLess = 10;
constexpr double kWidth_nm = 0.1, kWidth_arcsec = 1e-4;  // of a play that every move takes up

// Sides of every motor: what a play narrower than any move leaves behind. Rows that learn.
Eigen::MatrixXd sides(const Dataset& path, const Problem& problem) {
  std::vector<effects::Term> plays;
  for (const auto& column : path.columns) {
    const auto& [symbol, unit] = column.channel;
    if (!is_motor_symbol(symbol)) continue;
    const effects::Quantity width = unit == "mm" ? effects::Quantity{kWidth_nm, "nm"}
                                                 : effects::Quantity{kWidth_arcsec, "arcsec"};
    plays.push_back({{effects::Call{"play", {symbol}, {width}}}});
  }
  const auto columns = calibration::raw_columns(path, plays);
  return columns ? Eigen::MatrixXd(rows_of(*columns, problem.learn)) : Eigen::MatrixXd();
}

// Less its mean over the rows at one place of all motors, so that nothing that goes with the place
// hides a play. As they are where most rows have a place of their own.
class WithinPlaces {
 public:
  WithinPlaces(const Problem& problem, const Dataset& dataset) {
    std::map<std::vector<double>, Eigen::Index> numbers;
    for (const std::size_t row : problem.learn) {
      std::vector<double> place;
      for (const auto& column : dataset.columns)
        if (is_motor_symbol(column.channel.symbol)) place.push_back(column.values[row]);
      place_of_.push_back(
          numbers.emplace(std::move(place), static_cast<Eigen::Index>(numbers.size()))
              .first->second);
    }
    places_ = static_cast<Eigen::Index>(numbers.size());
  }

  Eigen::MatrixXd operator()(Eigen::MatrixXd values) const {
    if (2 * places_ > values.rows()) return values;
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(places_, values.cols());
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(places_);
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      sums.row(place_of_[static_cast<std::size_t>(i)]) += values.row(i);
      counts[place_of_[static_cast<std::size_t>(i)]] += 1;
    }
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      const Eigen::Index place = place_of_[static_cast<std::size_t>(i)];
      values.row(i) -= sums.row(place) / counts[place];
    }
    return values;
  }

 private:
  std::vector<Eigen::Index> place_of_;
  Eigen::Index places_ = 0;
};

double two_ln_likelihood(const Problem& problem, const WithinPlaces& within,
                         const Eigen::MatrixXd& further) {
  const Eigen::MatrixXd base = rows_of(problem.base_columns, problem.learn);
  Eigen::MatrixXd columns(base.rows(), base.cols() + further.cols());
  columns << base, further;
  columns = within(columns);
  const Eigen::RowVectorXd lengths = columns.colwise().norm().cwiseMax(1e-300);
  columns = columns * lengths.cwiseInverse().asDiagonal();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  double sum = 0;
  for (const auto& output : problem.outputs) {
    const Eigen::VectorXd measured = within(rows_of(output.measured, problem.learn));
    const double left = (measured - columns * qr.solve(measured)).squaredNorm();
    sum -= static_cast<double>(base.rows()) * std::log(std::max(left, 1e-300));
  }
  return sum;
}

std::string overruns_at_turns(const Problem& problem, const Dataset& dataset) {
  if (dataset.time_s.empty() || says_overruns(dataset)) return "";
  const auto rows = rows_after_overruns(dataset);
  if (rows.empty()) return "";
  Dataset with = dataset;
  with.metadata.emplace_back(kOverruns, "yes");
  const Eigen::MatrixXd plain = sides(dataset, problem), overrun = sides(with, problem);
  if (plain.cols() == 0 || !plain.allFinite() || !overrun.allFinite()) return "";
  const WithinPlaces within(problem, dataset);
  if (two_ln_likelihood(problem, within, overrun) <
      two_ln_likelihood(problem, within, plain) + kFarLess)
    return "";
  return std::to_string(rows.size()) + " rows (the first is row " + std::to_string(rows[0] + 1) +
         ") repeat a target where the axis turns, and read as if it had gone past the target in "
         "between, as ISO 230-2 has it: they count as reached from the other side. For a fit, "
         "write "
         "\"# overruns: yes\" at the head of the file";
}

}  // namespace

Result<Problem> lay_out_on_path(Dataset& data, const calibration::Candidates& baseline,
                                std::size_t longest, Judging judging,
                                std::vector<std::string>& sentences) {
  DRIFTWISE_TRY(auto problem, lay_out(data, baseline, longest, judging));
  auto said = overruns_at_turns(problem, data);
  if (said.empty()) return problem;
  sentences.push_back(std::move(said));
  data.metadata.emplace_back(kOverruns, "yes");
  return lay_out(data, baseline, longest, judging);
}

}  // namespace driftwise::diagnosis
