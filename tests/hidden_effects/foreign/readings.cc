#include "tests/hidden_effects/foreign/readings.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <set>

#include "tests/hidden_effects/foreign/hidden.h"
#include "tests/hidden_effects/foreign/strength.h"

namespace driftwise::foreign {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Widths of the smoothing that are tried, in rows; 0: none.
constexpr double kSmoothings[] = {0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0};
// Motion of a motor that counts as holding its place, in noise standard deviations; 0: none does.
// The controller holds to 5 at most (make_campaign).
constexpr double kHolding[] = {0.0, 25.0};

// Causes that a row, an instant or the reading itself defines, which the file has exactly.
// noise_change has no column.
bool is_event(const std::string& cause) {
  static const std::set<std::string> events{"step_change", "outliers", "sensor_fault",
                                            "noise_change"};
  return events.count(cause) > 0;
}

bool is_of_motion(const std::string& cause) {
  static const std::set<std::string> motion{"backlash", "creep", "self_heating",
                                            "probe_hysteresis"};
  return motion.count(cause) > 0;
}

// Local straight lines with Gaussian weights over the rows around each row.
MatrixXd smoothed(const VectorXd& place, const MatrixXd& series, double width) {
  MatrixXd out(series.rows(), series.cols());
  for (Eigen::Index i = 0; i < series.rows(); ++i) {
    const VectorXd gap = (place.array() - place[i]) / width;
    const VectorXd weight = (-0.5 * gap.array().square()).exp();
    const double zeroth = weight.sum();
    const double first = weight.dot(gap);
    const double second = weight.dot(gap.cwiseAbs2());
    const double area = zeroth * second - first * first;
    // A row alone within its width keeps its reading.
    if (!(area > 1e-9 * zeroth * zeroth)) {
      out.row(i) = series.row(i);
      continue;
    }
    const VectorXd kernel = weight.array() * (second - first * gap.array()) / area;
    out.row(i) = kernel.transpose() * series;
  }
  return out;
}

double median_step(const VectorXd& time_s) {
  VectorXd steps = time_s.tail(time_s.size() - 1) - time_s.head(time_s.size() - 1);
  std::sort(steps.begin(), steps.end());
  return steps[steps.size() / 2];
}

// Moves from row to row. Each ends where the dwell of its row begins.
std::vector<Move> moves_of_rows(const Campaign& campaign, double holding) {
  std::vector<Move> moves;
  VectorXd at = campaign.s.row(0).transpose();
  for (int i = 1; i < campaign.rows(); ++i) {
    VectorXd to = campaign.s.row(i).transpose();
    for (int j = 0; j < campaign.robot.axes; ++j) {
      if (std::abs(to[j] - at[j]) < holding * campaign.robot.sigma[j] / campaign.robot.half[j]) {
        to[j] = at[j];
      }
    }
    const double dwell_s =
        campaign.has_dwell ? campaign.visits[static_cast<std::size_t>(i)].dwell_s : 0.0;
    const double begin_s = campaign.time_s[i - 1];
    moves.push_back({begin_s, std::max(begin_s, campaign.time_s[i] - dwell_s), at, to});
    at = to;
  }
  return moves;
}

// Campaign in which every channel is as the file has it. Motor values are exact in the file, and
// with them the place by the baseline's geometry. Between rows temperatures go straight, and the
// activity of a row has lasted since the row before.
Campaign campaign_of_file(const Campaign& campaign, const MatrixXd& tilt_read, double smoothing,
                          double holding) {
  Campaign file = campaign;
  const int rows = campaign.rows();
  if (campaign.has_tilts && tilt_read.size() > 0) {
    file.tilt = tilt_read;
  }
  if (smoothing > 0.0) {
    const VectorXd numbers = VectorXd::LinSpaced(rows, 0.0, rows - 1.0);
    const VectorXd place =
        campaign.has_times ? VectorXd(campaign.time_s / median_step(campaign.time_s)) : numbers;
    file.body = smoothed(place, campaign.read, smoothing);
  } else {
    file.body = campaign.read;
  }
  file.moves = moves_of_rows(campaign, holding);
  file.room.motion.setZero();
  spread_motion(file.room, file.moves);
  int row = 0;
  for (Eigen::Index k = 0; k < file.room.activity.size(); ++k) {
    const double t = static_cast<double>(k) * file.room.step_s;
    while (row < rows - 1 && campaign.time_s[row] < t) {
      ++row;
    }
    const int before = std::max(0, row - 1);
    const double span = campaign.time_s[row] - campaign.time_s[before];
    const double part =
        span > 0.0 ? std::clamp((t - campaign.time_s[before]) / span, 0.0, 1.0) : 0.0;
    file.room.body.row(k) = (1.0 - part) * file.body.row(before) + part * file.body.row(row);
    file.room.activity[k] = campaign.activity[row];
  }
  return file;
}

MatrixXd effect_on_pose(const Campaign& campaign, const Errors& errors) {
  const MatrixXd none = campaign.no_motor_error();
  return campaign.effect(campaign.pose(errors.dq, errors.dp, campaign.read),
                         campaign.pose(none, none, campaign.read));
}

// Orthonormal basis of what the smoothed thermometers of the baseline add to the baseline.
MatrixXd smoothed_baseline(const Campaign& campaign, const Whitened& whitened,
                           const MatrixXd& body) {
  MatrixXd series(campaign.rows(), static_cast<Eigen::Index>(campaign.offered.size()));
  for (std::size_t k = 0; k < campaign.offered.size(); ++k) {
    const VectorXd one = body.col(campaign.offered[k]);
    series.col(static_cast<Eigen::Index>(k)) = one.array() - one[0];
  }
  const MatrixXd white = whitened.whiten_columns(series);
  MatrixXd clear = whitened.clear_columns(series);
  for (Eigen::Index k = 0; k < clear.cols(); ++k) {
    const bool lost =
        clear.col(k).norm() < 1e-9 * white.col(k).norm() || clear.col(k).norm() == 0.0;
    clear.col(k) *= lost ? 0.0 : 1.0 / clear.col(k).norm();
  }
  Eigen::ColPivHouseholderQR<MatrixXd> qr(clear);
  qr.setThreshold(1e-9);
  return qr.householderQ() * MatrixXd::Identity(clear.rows(), qr.rank());
}

struct Explained {
  double sum = 0.0;
  int columns = 0;
};

// Gain of one free amplitude per pose coordinate, against noise and what is left with it.
// All three are whitened, cleared, rows x coordinates.
Explained explained_by(const MatrixXd& columns, const MatrixXd& effect, const MatrixXd& leak,
                       double freedom) {
  Explained out;
  for (Eigen::Index j = 0; j < effect.cols(); ++j) {
    const double size = columns.col(j).norm();
    if (!(size > 1e-9 * columns.norm())) {
      continue;
    }
    ++out.columns;
    const VectorXd along = columns.col(j) / size;
    const double part = along.dot(effect.col(j));
    const double left = effect.col(j).squaredNorm() - part * part;
    const double leaked = leak.col(j).squaredNorm() - std::pow(along.dot(leak.col(j)), 2);
    out.sum += part * part / (1.0 + std::max(0.0, left + leaked) / std::max(1.0, freedom));
  }
  return out;
}

}  // namespace

Carried carried_by_readings(const Campaign& campaign, const Planted& planted, const MatrixXd& given,
                            const MatrixXd& tilt_read) {
  const Whitened whitened(campaign, given);
  const MatrixXd effect = whitened.clear(planted.effect);
  Carried carried;
  carried.chi2 = effect.squaredNorm();
  if (is_event(planted.cause)) {
    carried.in_readings = carried.in_smoothed_readings = carried.chi2;
    return carried;
  }
  const MatrixXd none = campaign.no_motor_error();
  const MatrixXd leak = whitened.clear(campaign.effect(campaign.pose(none, none, campaign.body),
                                                       campaign.pose(none, none, campaign.read)));
  const double rows = static_cast<double>(effect.rows());
  for (const double smoothing : kSmoothings) {
    if (smoothing > 0.0 && planted.cause.rfind("thermal_", 0) != 0) {
      break;
    }
    for (const double holding : kHolding) {
      if (holding > 0.0 && !is_of_motion(planted.cause)) {
        break;
      }
      const Campaign file = campaign_of_file(campaign, tilt_read, smoothing, holding);
      Random stream = planted.stream;
      const Hidden cause = draw_cause(planted.cause, file, stream);
      const MatrixXd columns =
          whitened.clear(effect_on_pose(campaign, cause.errors(planted.amplitude)));
      const MatrixXd also = smoothing > 0.0 && !campaign.offered.empty()
                                ? smoothed_baseline(campaign, whitened, file.body)
                                : MatrixXd(effect.rows(), 0);
      const auto beyond = [&also](const MatrixXd& table) -> MatrixXd {
        return table - also * (also.transpose() * table);
      };
      const double used = whitened.parameters() + static_cast<double>(also.cols()) + 1.0;
      const Explained found =
          explained_by(beyond(columns), beyond(effect), beyond(leak), rows - used);
      if (smoothing == 0.0 && found.sum > carried.in_readings) {
        carried.in_readings = found.sum;
        carried.columns = found.columns;
      }
      carried.in_smoothed_readings = std::max(carried.in_smoothed_readings, found.sum);
    }
  }
  return carried;
}

}  // namespace driftwise::foreign
