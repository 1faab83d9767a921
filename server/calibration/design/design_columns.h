#pragma once
// The matrix [1 | U | Y] of a design, made on demand and never held as a whole: blocks of its rows
// are written where they are used, so that a fit needs little memory beside its data.

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "server/calibration/design/basis.h"

namespace driftwise::calibration {

// Where the numbers of a design stand, one span per column of data, each over all rows of the
// dataset.
struct ColumnSources {
  std::vector<std::span<const double>> variables;  // in the order of Basis's variables
  std::vector<std::span<const double>> outputs;
  std::span<const double> weights;  // empty: all 1
  std::deque<std::vector<double>>
      storage;  // what is no column of the dataset: effects, datum constants. Never copied
};

// fill() and values() may be called from several threads at once.
class DesignColumns {
 public:
  DesignColumns() = default;
  // The dataset behind the sources outlives this. Errors: none.
  DesignColumns(ColumnSources sources, const std::vector<Variable>& variables, const Basis& basis);
  DesignColumns(DesignColumns&&) = default;
  DesignColumns& operator=(DesignColumns&&) = default;

  Eigen::Index width() const {
    return static_cast<Eigen::Index>(plan_.size() + sources_.outputs.size());
  }

  // rows: indices into the dataset. out: rows.size() x width(); each column less its mean, each row
  // times the root of its weight.
  void fill(std::span<const std::size_t> rows, Eigen::Ref<Eigen::MatrixXd> out) const;

  // Of one variable, as they stand in the data.
  std::span<const double> values(std::size_t variable) const {
    return sources_.variables[variable];
  }
  std::span<const double> output(std::size_t o) const { return sources_.outputs[o]; }
  double weight(std::size_t row) const {
    return sources_.weights.empty() ? 1 : sources_.weights[row];
  }

  // What stands off each column; the constant's is 0. Zero until take_off().
  const Eigen::VectorXd& means() const { return means_; }
  // Weighted means over these rows are taken off from now on: y of 60 000 +- 3 000 would otherwise
  // cost a digit. They need not be the means of all rows.
  void take_off_means_of(std::span<const std::size_t> rows);

 private:
  struct Scale {
    double mid = 0, inverse = 1;
  };
  struct Column {  // a monomial: its parent times one variable, or all its powers
    int variable = -1;
    Eigen::Index parent = -1;  // column, or -1
    Monomial whole;            // where the parent is no column
    bool plain = false;        // one variable to the first power
    bool parental = false;     // others are made from it
  };

  void fill_plain(const Column& column, std::span<const std::size_t> rows, double mean,
                  Eigen::Ref<Eigen::VectorXd> out) const;
  Eigen::VectorXd scaled(int variable, std::span<const std::size_t> rows) const;

  ColumnSources sources_;
  std::vector<Scale> scales_;
  std::vector<Column> plan_;
  Eigen::VectorXd means_;
};

}  // namespace driftwise::calibration
