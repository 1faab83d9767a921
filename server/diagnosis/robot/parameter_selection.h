#pragma once
// Which of the columns of a linear model with shared coefficients the data ask for: forward, the
// strongest first, each tested against chance with the price of looking at all that were offered;
// whatever the later ones make superfluous goes again.
//
// The rows are whitened before: errors are independent and of one size. Sums of squares of every
// subset come from one QR of all columns.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace driftwise::diagnosis {

class ParameterSelection {
 public:
  enum class Role : std::uint8_t { offered, always_in, left_out };

  // columns: rows x k, y: rows. roles: one per column. More rows than columns.
  ParameterSelection(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y,
                     std::vector<Role> roles);

  // Named with an adjusted p of at most alpha.
  void select(double alpha);

  const std::vector<std::size_t>& chosen() const { return chosen_; }  // in order of entry
  bool is_in(std::size_t column) const;                               // chosen or always
  double adjusted_p(std::size_t column) const;                        // of one that was chosen
  double gain_2lnl(std::size_t column) const;  // what 2 ln L loses without it
  // Columns that are not in, offered or not, and could stand for this one: within 6 in 2 ln L.
  std::vector<std::size_t> rivals(std::size_t column) const;

  // Of those always in and those chosen (0 elsewhere); without: leaves one out.
  Eigen::VectorXd coefficients(std::size_t without = kNone) const;
  Eigen::VectorXd standard_errors() const;

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

 private:
  std::vector<Eigen::Index> columns_in(std::size_t without = kNone, std::size_t with = kNone) const;
  double rss(const std::vector<Eigen::Index>& columns) const;
  double two_sided_p(double rss_without, double rss_with, std::size_t columns) const;

  Eigen::MatrixXd r_;  // triangular factor of (columns, y)
  Eigen::VectorXd scale_;
  double rows_ = 0;
  std::vector<Role> roles_;
  std::vector<std::size_t> chosen_;
};

}  // namespace driftwise::diagnosis
