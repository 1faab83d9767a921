#pragma once
// Which of the columns of a linear model with shared coefficients the data ask for: forward, the
// strongest first, each tested against chance with the price of looking at all that were offered;
// whatever the later ones make superfluous goes again.
//
// The rows are whitened before: errors are independent and of one size. A few dozen rows do not say
// how their noise is correlated, and a correlation that they only seem to have makes a column's
// evidence too large. So the rows may come whitened in several ways: a column's p is the largest of
// them, everything else is of the first. Sums of squares of every subset come from one QR of all
// columns.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace driftwise::diagnosis {

class ParameterSelection {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  enum class Role : std::uint8_t { offered, always_in, left_out };

  // One way to whiten: rows x k and rows, more rows than columns.
  struct Whitened {
    const Eigen::MatrixXd& columns;
    const Eigen::VectorXd& y;
  };
  // roles: one per column.
  ParameterSelection(const std::vector<Whitened>& ways, std::vector<Role> roles);

  // Named with an adjusted p of at most alpha.
  void select(double alpha);
  // Takes a column out for good; select() goes on without it.
  void forbid(std::size_t column);

  const std::vector<std::size_t>& chosen() const { return chosen_; }  // in order of entry
  bool is_in(std::size_t column) const;                               // chosen or always
  std::vector<Eigen::Index> columns_in(std::size_t without = kNone, std::size_t with = kNone) const;
  double adjusted_p(std::size_t column) const;  // of one that was chosen
  double gain_2lnl(std::size_t column) const;   // what 2 ln L loses without it
  // Columns that are not in, offered or not, and could stand for this one: within 6 in 2 ln L.
  std::vector<std::size_t> rivals(std::size_t column) const;

  // Of those always in and those chosen (0 elsewhere); without: leaves one out.
  Eigen::VectorXd coefficients(std::size_t without = kNone) const;
  Eigen::VectorXd coefficients_of_none() const;  // of those always in, with nothing chosen
  Eigen::VectorXd standard_errors() const;

 private:
  double rss(const std::vector<Eigen::Index>& columns, std::size_t way = 0) const;
  Eigen::VectorXd fitted(const std::vector<Eigen::Index>& in) const;
  // Of one column beside others.
  double two_sided_p(const std::vector<Eigen::Index>& without,
                     const std::vector<Eigen::Index>& with) const;

  std::vector<Eigen::MatrixXd> r_;  // of each way, triangular factor of (columns, y)
  Eigen::VectorXd scale_;           // of the first way's columns
  double rows_ = 0;
  std::vector<Role> roles_;
  std::vector<std::size_t> chosen_;
  std::vector<char> forbidden_;
};

}  // namespace driftwise::diagnosis
