#pragma once
// Least squares of further right sides on the columns of a model that is already fitted: what
// systematic errors and correlated noise do to its coefficients.
//
// The columns are centred where there is a constant, scaled to unit length and made orthonormal: X
// = Q R. Raw coefficients = back * (Q' y).

#include <Eigen/Core>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"

namespace driftwise::calibration {

// The rows of a fit that are looked at, with what is needed of them.
class Excerpt {
 public:
  // Of these rows of the dataset, in order, at most so many (evenly spread) where nothing speaks
  // against it: an effect with memory or several datums need the whole.
  Excerpt(const Dataset& dataset, const std::vector<std::size_t>& rows, const OutputModel& output,
          std::size_t at_most);

  Eigen::Index size() const { return static_cast<Eigen::Index>(rows_.size()); }
  // Errors: those of raw_columns.
  Result<Eigen::MatrixXd> columns(const std::vector<effects::Term>& terms) const;
  const DatasetColumn* find(const std::string& symbol) const { return data_.find(symbol); }
  // Columns in degC.
  std::vector<const DatasetColumn*> thermometers() const;
  Eigen::VectorXd values(const DatasetColumn& column) const;
  // Of row i among those of the fit, in order.
  Eigen::Index place(Eigen::Index i) const { return place_[static_cast<std::size_t>(i)]; }
  // Row by row; time_s: empty when the data have no times.
  const std::vector<double>& time_s() const { return time_s_; }
  const std::vector<double>& datum() const { return datum_; }

 private:
  Dataset data_;
  std::vector<Eigen::Index> rows_, place_;
  std::vector<double> time_s_, datum_;
};

class Projection {
 public:
  // columns: as raw_columns gives them for the terms; weights: one per row, or empty.
  Projection(Eigen::MatrixXd columns, const std::vector<effects::Term>& terms,
             const Eigen::VectorXd& weights);

  // Raw coefficients of the least squares for y (not weighted yet).
  Eigen::VectorXd coefficients(const Eigen::VectorXd& y) const;
  // The same over some of the rows, for a y that has these rows only. What they do not determine of
  // the coefficients is 0 (least norm of the fitted values over all rows).
  Projection over(const std::vector<Eigen::Index>& rows) const;
  // rows x terms; orthonormal, but for that of some of the rows.
  const Eigen::MatrixXd& q() const { return q_; }
  const Eigen::MatrixXd& back() const { return back_; }  // terms x terms

 private:
  Projection() = default;

  Eigen::VectorXd root_weights_;
  Eigen::MatrixXd q_, back_;
};

}  // namespace driftwise::calibration
