#include "tests/hidden_effects/foreign/rivals.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "tests/hidden_effects/foreign/constants.h"
#include "tests/hidden_effects/foreign/monomials.h"
#include "tests/hidden_effects/foreign/shapes.h"

namespace driftwise::foreign {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Share of a column's norm that must be left beyond the baseline for it to explain anything.
constexpr double kLeastLeft = 1e-3;

// Columns of candidate explanations, `width` columns each, on one pose coordinate or (-1) on all.
struct Bank {
  struct Entry {
    std::string cause;
    std::string subject;
    int width;
    int coordinate;
  };
  std::vector<Entry> entries;
  std::vector<VectorXd> columns;

  void add(const std::string& cause, const std::string& subject, const VectorXd& column,
           int coordinate = -1) {
    entries.push_back({cause, subject, 1, coordinate});
    columns.push_back(column);
  }
  void add_wave(const std::string& cause, const std::string& subject, const VectorXd& phase,
                int coordinate) {
    entries.push_back({cause, subject, 2, coordinate});
    columns.push_back(phase.array().sin());
    columns.push_back(phase.array().cos());
  }
};

void add_thermal(Bank& bank, const Campaign& campaign, const MatrixXd& u) {
  const double duration_s = campaign.time_s[campaign.rows() - 1];
  for (int k = 0; k < campaign.thermometer_count(); ++k) {
    const std::string symbol = thermometer_symbol(k);
    const VectorXd change = campaign.body.col(k).array() - campaign.body(0, k);
    const bool spare =
        std::find(campaign.offered.begin(), campaign.offered.end(), k) == campaign.offered.end();
    if (spare) {
      bank.add("thermal_offset", symbol, change);
    }
    for (int j = 0; j < campaign.robot.axes; ++j) {
      bank.add("thermal_expansion", symbol, change.cwiseProduct(u.col(j)));
    }
    if (campaign.has_times) {
      // A short lag of a thermometer that the baseline lacks is its offset, not a rival of it.
      for (double tau_s = duration_s / (spare ? 8.0 : 200.0); tau_s < 1.2 * duration_s;
           tau_s *= 1.35) {
        bank.add("thermal_lag", symbol, lag_shape(campaign, k, tau_s));
      }
      for (const double span_s : {30.0, 200.0}) {
        bank.add("thermal_rate", symbol,
                 rate_shape(campaign, k, span_s + 0.5 * campaign.room.step_s));
      }
    }
  }
}

void add_motion(Bank& bank, const Campaign& campaign) {
  const double duration_s = campaign.time_s[campaign.rows() - 1];
  for (int i = 0; i < campaign.robot.axes; ++i) {
    const std::string symbol = "q" + std::to_string(i + 1);
    for (const double width : {1e-5, 1e-3, 1e-2, 1e-1}) {
      bank.add("backlash", symbol, play_shape(campaign, i, width * campaign.robot.motor_half[i]));
    }
    for (const double slide : {0.005, 0.02}) {
      bank.add("probe_hysteresis", campaign.robot.pose[static_cast<std::size_t>(i)],
               friction_shape(campaign, i, slide), i);
    }
    if (campaign.has_times) {
      for (double tau_s = 2.0; tau_s < 300.0; tau_s *= 1.6) {
        bank.add("creep", symbol, creep_shape(campaign, i, tau_s));
      }
      for (double tau_s = 120.0; tau_s < duration_s; tau_s *= 1.5) {
        bank.add("self_heating", symbol, motor_heat_shape(campaign, i, tau_s));
      }
    }
  }
}

void add_instruments(Bank& bank, const Campaign& campaign, const MatrixXd& u) {
  const double duration_s = campaign.time_s[campaign.rows() - 1];
  for (int j = 0; j < campaign.robot.axes; ++j) {
    const std::string& symbol = campaign.robot.pose[static_cast<std::size_t>(j)];
    const int direction = direction_of(symbol);
    if (campaign.has_tilts && direction >= 0) {
      for (int k = 1; k <= 2; ++k) {
        const int other = (direction + k) % 3;
        bank.add("abbe_offset", symbol, abbe_shape(campaign, direction, other), j);
        bank.add("cosine_error", symbol, cosine_shape(campaign, j, other, 3e-3), j);
      }
    }
    if (campaign.has_air && direction >= 0) {
      bank.add("refractive_index", symbol, air_shape(campaign), j);
    }
    for (const bool scale : {false, true}) {
      const bool angle = scale ? campaign.robot.motor_is_angle[j] : campaign.robot.pose_is_angle[j];
      const double half = scale ? campaign.robot.motor_half[j] : campaign.robot.half[j];
      const std::string name = scale ? "q" + std::to_string(j + 1) : symbol;
      for (const double period : periods(angle, scale)) {
        if (period > 4.0 * campaign.robot.sigma[j] && period < 2.0 * half) {
          const VectorXd at = scale ? VectorXd(campaign.s.col(j)) : VectorXd(u.col(j));
          bank.add_wave("cyclic_error", name, kTurn * half / period * at, scale ? -1 : j);
        }
      }
    }
    if (campaign.has_times) {
      bank.add("instrument_drift", symbol, campaign.time_s, j);
      for (int k = 1; k < 60; ++k) {
        const int row = k * campaign.rows() / 60;
        VectorXd step = VectorXd::Zero(campaign.rows());
        step.tail(campaign.rows() - row).setOnes();
        bank.add("step_change", symbol, step, j);
      }
      for (int k = 3; k < campaign.rows() / 3; ++k) {
        bank.add_wave("periodic_disturbance", symbol,
                      kTurn * 0.5 * k / duration_s * campaign.time_s, j);
      }
    }
  }
}

void add_rest(Bank& bank, const Campaign& campaign, const MatrixXd& u) {
  const int wanted = campaign.degree + 1;
  for (const std::vector<int>& powers : monomials(campaign.robot.axes, wanted)) {
    int total = 0;
    int main = 0;
    for (std::size_t j = 0; j < powers.size(); ++j) {
      total += powers[j];
      main = powers[j] > powers[static_cast<std::size_t>(main)] ? static_cast<int>(j) : main;
    }
    if (total == wanted) {
      VectorXd column(campaign.rows());
      for (int i = 0; i < campaign.rows(); ++i) {
        column[i] = monomial_value(powers, u.row(i).transpose());
      }
      bank.add("geometry_order", campaign.robot.pose[static_cast<std::size_t>(main)], column);
    }
  }
  if (campaign.has_force) {
    const VectorXd share = campaign.force_n / std::max(1e-12, campaign.force_n.maxCoeff());
    if (!campaign.force_offered) {
      bank.add("force_compliance", "F", share);
    }
    bank.add("force_nonlinearity", "F", share.array().pow(2.0 / 3.0));
    bank.add("force_nonlinearity", "F", share.array().square());
    for (int j = 0; j < campaign.robot.axes; ++j) {
      bank.add("force_position_coupling", "F", share.cwiseProduct(u.col(j)));
    }
  }
  if (campaign.has_activity && campaign.has_times) {
    for (double tau_s = 120.0; tau_s < campaign.time_s[campaign.rows() - 1]; tau_s *= 1.6) {
      for (const double power : {1.0, 2.0}) {
        bank.add("activity_heating", "activity", activity_heat_shape(campaign, tau_s, power));
      }
    }
  }
}

// Squared length of v in the span of one or two columns.
double explained(const MatrixXd& columns, const VectorXd& v) {
  const VectorXd first = columns.col(0).normalized();
  double sum = std::pow(first.dot(v), 2);
  if (columns.cols() > 1) {
    const VectorXd rest = columns.col(1) - first * first.dot(columns.col(1));
    if (rest.norm() > 1e-6 * columns.col(1).norm()) {
      sum += std::pow(rest.normalized().dot(v), 2);
    }
  }
  return sum;
}

}  // namespace

std::vector<Rival> rivals_of(const Campaign& campaign, const Whitened& whitened,
                             const MatrixXd& effect, const MatrixXd& beside) {
  const MatrixXd u = campaign.clean_u();
  Bank bank;
  if (campaign.thermometer_count() > 0) {
    add_thermal(bank, campaign, u);
  }
  add_motion(bank, campaign);
  add_instruments(bank, campaign, u);
  add_rest(bank, campaign, u);

  MatrixXd v = whitened.clear(effect);
  MatrixXd known = MatrixXd::Zero(v.rows(), v.cols());
  if (beside.size() > 0) {
    known = whitened.clear(beside);
    for (Eigen::Index j = 0; j < v.cols(); ++j) {
      if (known.col(j).norm() > 0.0) {
        known.col(j).normalize();
        v.col(j) -= known.col(j) * known.col(j).dot(v.col(j));
      }
    }
  }
  const double chi2 = v.squaredNorm();
  MatrixXd all(campaign.rows(), static_cast<Eigen::Index>(bank.columns.size()));
  for (std::size_t k = 0; k < bank.columns.size(); ++k) {
    const VectorXd centred = bank.columns[k].array() - bank.columns[k].mean();
    all.col(static_cast<Eigen::Index>(k)) = centred / std::max(1e-300, centred.norm());
  }
  const MatrixXd white = whitened.whiten_columns(all);
  const MatrixXd clear = whitened.clear_columns(all);

  std::map<std::pair<std::string, std::string>, double> best;
  Eigen::Index at = 0;
  for (const Bank::Entry& entry : bank.entries) {
    const bool lost =
        clear.col(at).norm() < kLeastLeft * white.col(at).norm() || white.col(at).norm() == 0.0;
    if (!lost) {
      double sum = 0.0;
      for (Eigen::Index j = 0; j < v.cols(); ++j) {
        if ((entry.coordinate < 0 || entry.coordinate == j) && v.col(j).squaredNorm() > 0.0) {
          MatrixXd columns = clear.middleCols(at, entry.width);
          columns -= known.col(j) * (known.col(j).transpose() * columns);
          sum += columns.col(0).norm() > 1e-12 ? explained(columns, v.col(j)) : 0.0;
        }
      }
      double& kept = best.try_emplace({entry.cause, entry.subject}, 0.0).first->second;
      kept = std::max(kept, sum);
    }
    at += entry.width;
  }
  std::vector<Rival> rivals;
  for (const auto& [name, sum] : best) {
    rivals.push_back({name.first, name.second, chi2 - sum});
  }
  std::sort(rivals.begin(), rivals.end(),
            [](const Rival& a, const Rival& b) { return a.gap < b.gap; });
  return rivals;
}

}  // namespace driftwise::foreign
