#pragma once
// Rows of a robot left out of a fit: what the others foretell of them, and what of an amplitude
// rests on them. Outputs are stacked: output after output, each with the same rows.

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace driftwise::diagnosis {

using Folds = std::vector<std::vector<std::size_t>>;  // rows of one output, each fold in order

// Of inputs x rows: those rows x inputs, each input from 0 to 1 over them.
Eigen::MatrixXd scaled_rows(const Eigen::MatrixXd& inputs, const std::vector<std::size_t>& rows);

Folds folds_of_time(std::size_t rows);
// Neighbouring poses. places: rows x inputs, scaled alike.
Folds folds_of_places(const Eigen::MatrixXd& places);
// Six parts of what is a function of `driver`, as many rows each.
Folds folds_of_driver(const Eigen::VectorXd& driver);

// Least squares with the columns of something in question last.
class LeftOut {
 public:
  // base: orthonormal columns; own: columns beyond it. precision: of the prior of each column of
  // `own`; y in units of its noise. rows: of one output.
  LeftOut(const Eigen::MatrixXd& base, const Eigen::MatrixXd& own, const Eigen::VectorXd& precision,
          Eigen::Index in_question, Eigen::VectorXd y, Eigen::Index rows);

  // Growth of 2 ln of the predictive density of the folds by the columns in question.
  double growth(const Folds& folds) const { return growth(folds, 0); }
  // The same of blocks of time, each with 4 % of all rows on either side left out as well.
  double growth_over_time(const Folds& folds) const;
  // Size of what is in question over its standard error by the jackknife over the folds; along
  // itself where it has several columns.
  double t_without(const Folds& folds) const;

 private:
  double growth(const Folds& folds, std::size_t idle_rows) const;
  std::vector<Eigen::Index> stacked(const std::vector<std::size_t>& rows) const;

  Eigen::MatrixXd all_, gram_;
  Eigen::VectorXd along_, precision_, y_;
  Eigen::Index own_, rows_, outputs_;
};

}  // namespace driftwise::diagnosis
