#include "server/correction/join_angles.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "server/core/units.h"
#include "server/correction/join_agreement.h"
#include "server/correction/return_subtraction.h"
#include "server/correction/robust.h"

namespace driftwise::correction {
namespace {

constexpr std::array<const char*, 3> kRotations = {"rx", "ry", "rz"};
constexpr std::size_t kNone = 3;

using Sources = std::array<std::vector<std::size_t>, 3>;  // parts, per rotation

// arcsec; of a part's row.
double angle_at(const JoinPart& part, std::size_t angle, std::size_t row) {
  const auto* column = part.data.find(kRotations[angle]);
  const double value = column->values[row];
  return is_missing(value) ? kMissing : summary_unit(column->channel.unit).factor * value;
}

Sources sources_of_angles(const JoinParts& parts) {
  Sources sources;
  for (std::size_t angle = 0; angle < 3; ++angle)
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const auto* column = parts[p].data.find(kRotations[angle]);
      if (column && is_angle(column->channel.unit) &&
          std::ranges::any_of(column->values, [](double value) { return !is_missing(value); }))
        sources[angle].push_back(p);
    }
  return sources;
}

bool measures(const Sources& sources, std::size_t part, std::size_t angle) {
  return std::ranges::find(sources[angle], part) != sources[angle].end();
}

// The rotation that a part measures with this one; kNone: none, or two (no single autocollimator).
std::size_t partner_of(const Sources& sources, std::size_t part, std::size_t angle) {
  std::size_t partner = kNone, count = 0;
  for (std::size_t other = 0; other < 3; ++other)
    if (other != angle && measures(sources, part, other)) {
      partner = other;
      ++count;
    }
  return count == 1 ? partner : kNone;
}

bool is_return(const JoinPart& part, std::size_t row) {
  return !part.data.zero.empty() && part.data.zero[row] != 0;
}

// Poses with every joined rotation, and the difference of the two parts.
struct Compared {
  Eigen::MatrixXd joined;      // a column per rotation of `angles`
  Eigen::VectorXd difference;  // first less second, arcsec
};

Compared compared(const JoinParts& parts, const MatchedRows& rows, const Sources& sources,
                  const std::vector<std::size_t>& angles, std::size_t common, std::size_t first,
                  std::size_t second) {
  const auto columns = static_cast<Eigen::Index>(angles.size());
  Compared out;
  out.joined.resize(static_cast<Eigen::Index>(rows.row.size()), columns);
  out.difference.resize(static_cast<Eigen::Index>(rows.row.size()));
  Eigen::Index kept = 0;
  for (std::size_t k = 0; k < rows.row.size(); ++k) {
    if (is_return(parts[first], rows.index[first][k])) continue;
    Eigen::VectorXd at = Eigen::VectorXd::Zero(columns);
    for (Eigen::Index c = 0; c < columns; ++c) {
      const auto& from = sources[angles[static_cast<std::size_t>(c)]];
      for (const auto p : from)
        at[c] += angle_at(parts[p], angles[static_cast<std::size_t>(c)], rows.index[p][k]) /
                 static_cast<double>(from.size());
    }
    const double difference = angle_at(parts[first], common, rows.index[first][k]) -
                              angle_at(parts[second], common, rows.index[second][k]);
    if (!at.allFinite() || !std::isfinite(difference)) continue;
    out.joined.row(kept) = at.transpose();
    out.difference[kept++] = difference;
  }
  out.joined.conservativeResize(kept, columns);
  out.difference.conservativeResize(kept);
  return out;
}

struct Slopes {
  Eigen::VectorXd value, u;  // a slope per rotation, then the constant
  double scatter = 0;        // standard deviation of what the line leaves, arcsec
};

// Least squares, without rows further off than five robust standard deviations: a single wrong row
// is no roll. Empty: fewer than twice as many rows as unknowns, or rotations in step.
std::optional<Slopes> slopes_of(const Compared& data) {
  constexpr double kFarOff = 5;
  const Eigen::Index unknowns = data.joined.cols() + 1;
  Eigen::MatrixXd design(data.joined.rows(), unknowns);
  design << data.joined, Eigen::VectorXd::Ones(data.joined.rows());
  Eigen::VectorXd right = data.difference;
  for (int pass = 0;; ++pass) {
    if (right.size() < 2 * unknowns) return std::nullopt;
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(design);
    if (qr.rank() < unknowns) return std::nullopt;
    Slopes line;
    line.value = qr.solve(right);
    const Eigen::VectorXd left = right - design * line.value;
    const double dof = static_cast<double>(right.size() - unknowns);
    line.scatter = std::sqrt(left.squaredNorm() / dof);
    if (pass > 0) {
      const Eigen::MatrixXd inverse = (design.transpose() * design).inverse();
      line.u = line.scatter * inverse.diagonal().cwiseMax(0).cwiseSqrt();
      if (!line.u.allFinite()) return std::nullopt;
      return line;
    }
    const double limit =
        kFarOff * robust_sigma(std::vector<double>(left.data(), left.data() + left.size()));
    Eigen::Index kept = 0;
    for (Eigen::Index row = 0; row < left.size(); ++row)
      if (limit <= 0 || std::abs(left[row]) <= limit) {
        design.row(kept) = design.row(row).eval();
        right[kept++] = right[row];
      }
    design.conservativeResize(kept, unknowns);
    right.conservativeResize(kept);
  }
}

double mean_square(const Eigen::VectorXd& values) {
  return values.squaredNorm() / static_cast<double>(values.size());
}

// A slope whose square is less by that of its own standard uncertainty, which the scatter adds to
// it; 0 where the rows show no slope: small rotations cannot tell a scale error of 5 %, which no
// autocollimator has, from none.
double beyond_scatter(double slope, double u) {
  return std::copysign(std::sqrt(std::max(0.0, slope * slope - u * u)), slope);
}

// Mean square of the mean of two parts' readings at the returns to zero that both have, arcsec^2.
std::optional<double> drift_of_mean(const JoinParts& parts, const MatchedRows& rows,
                                    std::size_t angle, std::size_t first, std::size_t second) {
  std::vector<std::pair<std::size_t, double>> returns;  // by the first part's order of time
  for (std::size_t k = 0; k < rows.row.size(); ++k) {
    const std::size_t a = rows.index[first][k], b = rows.index[second][k];
    if (!is_return(parts[first], a) || !is_return(parts[second], b)) continue;
    const double mean = (angle_at(parts[first], angle, a) + angle_at(parts[second], angle, b)) / 2;
    if (std::isfinite(mean)) returns.emplace_back(a, mean);
  }
  if (returns.size() < 2) return std::nullopt;
  std::ranges::sort(returns);
  std::vector<double> values;
  for (const auto& [row, mean] : returns) values.push_back(mean);
  const auto kept = without_jumps(values);
  return mean_square(Eigen::Map<const Eigen::VectorXd>(kept.data(), std::ssize(kept)));
}

class Estimate {
 public:
  Estimate(const JoinParts& parts, const MatchedRows& rows, const JoinRules& rules)
      : parts_(parts), rows_(rows), rules_(rules), sources_(sources_of_angles(parts)) {
    for (std::size_t angle = 0; angle < 3; ++angle)
      if (!sources_[angle].empty()) angles_.push_back(angle);
    // Subtracted returns leave no drift.
    if (rules.subtract_returns) {
      steady_ = parts;
      return;
    }
    for (const auto& part : parts) {
      steady_.push_back(part);
      if (!subtract_returns(rows_at_zero(part, rules), steady_.back())) {
        steady_.clear();
        return;
      }
    }
  }

  AngleErrors run() {
    for (std::size_t common = 0; common < 3; ++common)
      if (sources_[common].size() == 2) compare(common, sources_[common][0], sources_[common][1]);
    return out_;
  }

 private:
  void compare(std::size_t common, std::size_t first, std::size_t second) {
    const auto drift = drift_of_mean(parts_, rows_, common, first, second);
    if (!drift || steady_.empty()) return;
    const auto data = compared(steady_, rows_, sources_, angles_, common, first, second);
    const auto slopes = slopes_of(data);
    if (!slopes) return;
    const auto column = [&](std::size_t angle) {
      return static_cast<Eigen::Index>(std::ranges::find(angles_, angle) - angles_.begin());
    };
    const auto scale = slopes->value[column(common)], u_scale = slopes->u[column(common)];
    const double scale2 = std::pow(beyond_scatter(scale, u_scale), 2) / 2;
    const Eigen::VectorXd j = data.joined.col(column(common));
    const std::size_t k = partner_of(sources_, first, common),
                      i = partner_of(sources_, second, common);
    // The rolls' part of the mean of the two readings is known in every row; the mean of the scales
    // has as much error as half their difference, and so has the rest.
    Eigen::VectorXd of_rolls = Eigen::VectorXd::Zero(j.size());
    if (k != kNone && k != i) {
      of_rolls += beyond_scatter(slopes->value[column(k)], slopes->u[column(k)]) / 2 *
                  data.joined.col(column(k));
      add_single(first, k, slopes->value[column(k)], slopes->u[column(k)], j,
                 data.joined.col(column(k)), scale2);
    }
    if (i != kNone && k != i) {
      of_rolls -= beyond_scatter(slopes->value[column(i)], slopes->u[column(i)]) / 2 *
                  data.joined.col(column(i));
      add_single(second, i, -slopes->value[column(i)], slopes->u[column(i)], j,
                 data.joined.col(column(i)), scale2);
    }
    const double constant = slopes->value[slopes->value.size() - 1];
    // The drift's figure has the noise of both readings already. The lines between returns add half
    // as much.
    constexpr double kWithLine = 1.5;
    const double noise2 = kWithLine * (noise_square(first, common) + noise_square(second, common));
    const double left2 = std::max(0.0, slopes->scatter * slopes->scatter - noise2);
    out_.square[common] = *drift + mean_square(of_rolls) + scale2 / 2 * mean_square(j) +
                          (left2 + constant * constant) / 4;
  }

  // Of one reading, by the returns about the lines between their neighbours, arcsec^2.
  double noise_square(std::size_t part, std::size_t angle) const {
    const auto& channel = parts_[part].data.find(kRotations[angle])->channel;
    const auto scatter = scatter_of_returns(parts_[part], rows_at_zero(parts_[part], rules_));
    const auto found = scatter.find(channel.name());
    return found == scatter.end() ? 0
                                  : std::pow(summary_unit(channel.unit).factor * found->second, 2);
  }

  // The other rotation of a part's autocollimator, where no second part measured it.
  void add_single(std::size_t part, std::size_t angle, double roll, double u_roll,
                  const Eigen::VectorXd& common, const Eigen::VectorXd& own, double scale2) {
    out_.rolls.push_back({parts_[part].name, roll, u_roll});
    if (sources_[angle].size() != 1) return;
    out_.square[angle] =
        (roll * roll + u_roll * u_roll) * mean_square(common) + scale2 * mean_square(own);
  }

  const JoinParts& parts_;
  JoinParts steady_;  // less the lines between their returns; none: not to be had
  const MatchedRows& rows_;
  const JoinRules& rules_;
  Sources sources_;
  std::vector<std::size_t> angles_;  // that any part measured
  AngleErrors out_;
};

}  // namespace

AngleErrors angle_errors(const JoinParts& parts, const MatchedRows& rows, const JoinRules& rules) {
  return Estimate(parts, rows, rules).run();
}

}  // namespace driftwise::correction
