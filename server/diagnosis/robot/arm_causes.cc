#include "server/diagnosis/robot/arm_causes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "server/core/units.h"
#include "server/kinematics/joint_errors.h"

namespace driftwise::diagnosis {
namespace {

using Eigen::Index;

// 10 kg on a gear of 1e5 N m/rad (Abele, CIRP Annals 56 (2007) 387: 1e4 to 1e6).
constexpr double kSag_urad_per_m = 1000, kSag_urad_per_newton_m = 10;
constexpr double kPlay_arcsec = 20;        // gears of arms are sold with less than a minute
constexpr double kGear_arcsec = 40;        // 10 um of eccentricity on a radius of 50 mm
constexpr double kDrift_arcsec_per_k = 5;  // twice the expansion of steel, 24 urad/K
constexpr double kDriftOfNoise = 10;       // as what nothing bounds in physics.h
constexpr double kRangeOfPlay = 10, kRangeOfGear = 10;
constexpr double kLeastTorque_m = 0.02, kLeastTorque_newton_m = 1;  // of change over the rows
constexpr double kLeastChange_k = 0.5;
constexpr double kLeastTurn_rad = 1e-3;  // over the rows; below, a joint stands
constexpr double kRadPerUrad = 1e-6, kKelvinOfZero = 273.15;

double range_of(const Eigen::VectorXd& values, const std::vector<std::size_t>& rows) {
  double low = INFINITY, high = -INFINITY;
  for (const std::size_t row : rows) {
    low = std::min(low, values[static_cast<Index>(row)]);
    high = std::max(high, values[static_cast<Index>(row)]);
  }
  return high - low;
}

// The reading less where a play of kPlay_arcsec lets the joint be, in widths: from -1/2 to 1/2.
Eigen::VectorXd lag_of_play(const Eigen::VectorXd& angle_rad) {
  constexpr double kWidth = kPlay_arcsec * kRadPerArcsec;
  Eigen::VectorXd lag(angle_rad.size());
  double joint = angle_rad.size() > 0 ? angle_rad[0] : 0;
  for (Index row = 0; row < angle_rad.size(); ++row) {
    joint = std::clamp(joint, angle_rad[row] - kWidth / 2, angle_rad[row] + kWidth / 2);
    lag[row] = (angle_rad[row] - joint) / kWidth;
  }
  return lag;
}

std::string name_of_joint(std::size_t joint) { return "joint" + std::to_string(joint + 1); }

class Builder {
 public:
  Builder(const Dataset& dataset, const std::vector<std::size_t>& rows,
          const KinematicsDescription& arm, Eigen::MatrixXd angles_rad)
      : dataset_(dataset), rows_(rows), arm_(arm), angles_rad_(std::move(angles_rad)) {}

  void add_gravity() {
    const bool masses = kinematics::has_masses(arm_);
    Eigen::MatrixXd torques(angles_rad_.rows(), angles_rad_.cols());
    for (Index row = 0; row < torques.rows(); ++row) {
      const Eigen::VectorXd angles = angles_rad_.row(row);
      torques.row(row) = kinematics::gravity_torques(
                             arm_, {angles.data(), static_cast<std::size_t>(angles.size())})
                             .transpose();
    }
    for (Index j = 0; j < torques.cols(); ++j) {
      const auto joint = static_cast<std::size_t>(j);
      const double least = masses ? kLeastTorque_newton_m : kLeastTorque_m;
      if (range_of(torques.col(j), rows_) < least) {
        missing("joint_compliance " + name_of_joint(joint),
                "gravity's torque about it hardly changes over these poses");
        continue;
      }
      ArmCause sag{.id = "joint_compliance", .subject = name_of_joint(joint), .joint = joint};
      sag.turns_rad = kRadPerUrad * torques.col(j);
      sag.driver = torques.col(j);
      sag.typical = masses ? kSag_urad_per_newton_m : kSag_urad_per_m;
      sag.one_signed = sag.certain = true;
      result_.causes.push_back(std::move(sag));
      Eigen::VectorXd side = torques.col(j);
      for (double& one : side) one = kinematics::play_side(one, masses) / 2;
      if (range_of(side, rows_) < 1) {
        missing("backlash " + name_of_joint(joint), "gravity's torque about it changes no sign");
        continue;
      }
      ArmCause play{.id = "backlash", .subject = name_of_joint(joint), .joint = joint};
      play.turns_rad = kRadPerArcsec * side;
      play.driver = torques.col(j);
      play.typical = kPlay_arcsec;
      play.range = kRangeOfPlay;
      play.one_signed = true;
      result_.causes.push_back(std::move(play));
    }
  }

  // Play of a joint that gravity hardly loads: friction leaves it on the flank that drove it last.
  void add_plays_by_motion() {
    for (Index j = 0; j < angles_rad_.cols(); ++j) {
      const auto joint = static_cast<std::size_t>(j);
      ArmCause play{
          .id = "backlash", .subject = name_of_joint(joint), .joint = joint, .by_motion = true};
      play.driver = lag_of_play(angles_rad_.col(j));
      if (range_of(play.driver, rows_) < 1) continue;
      play.turns_rad = -kRadPerArcsec * play.driver;
      play.typical = kPlay_arcsec;
      play.range = kRangeOfPlay;
      play.one_signed = true;
      result_.causes.push_back(std::move(play));
    }
  }

  void add_gears() {
    for (Index j = 0; j < angles_rad_.cols(); ++j) {
      if (range_of(angles_rad_.col(j), rows_) < kLeastTurn_rad) {
        missing("gear_error " + name_of_joint(static_cast<std::size_t>(j)),
                "the joint did not turn in these rows");
        continue;
      }
      for (const int harmonic : {1, 2}) {
        const auto joint = static_cast<std::size_t>(j);
        ArmCause gear{.id = "gear_error",
                      .subject = name_of_joint(joint),
                      .joint = joint,
                      .harmonic = harmonic};
        gear.turns_rad.resize(angles_rad_.rows(), 2);
        const Eigen::ArrayXd phase = harmonic * angles_rad_.col(j).array();
        gear.turns_rad.col(0) = kRadPerArcsec * phase.cos();
        gear.turns_rad.col(1) = kRadPerArcsec * phase.sin();
        gear.driver = angles_rad_.col(j);
        gear.typical = kGear_arcsec;
        gear.range = kRangeOfGear;
        result_.causes.push_back(std::move(gear));
      }
    }
  }

  void add_drifts() {
    bool any = false;
    for (const auto& column : dataset_.columns) {
      const Channel& channel = column.channel;
      if (channel.unit != "degC" && channel.unit != "K") continue;
      Eigen::VectorXd values = Eigen::Map<const Eigen::VectorXd>(
          column.values.data(), static_cast<Index>(column.values.size()));
      if (channel.unit == "K") values.array() -= kKelvinOfZero;
      bool whole = true;
      for (std::size_t row = 0; row < dataset_.rows; ++row)
        whole = whole && (dataset_.is_excluded(row) || std::isfinite(column.values[row]));
      if (!whole) {
        missing("joint_offset_drift", "readings of " + channel.symbol + " are missing");
        continue;
      }
      if (range_of(values, rows_) < kLeastChange_k) continue;
      any = true;
      double sum = 0;
      for (const std::size_t row : rows_) sum += values[static_cast<Index>(row)];
      const double mean = sum / static_cast<double>(rows_.size());
      for (std::size_t joint = 0; joint < arm_.links.size(); ++joint) {
        const Channel& read = arm_.links[joint].errors.drift_channel;
        if (!read.symbol.empty() && !(read == channel)) continue;
        ArmCause drift{.id = "joint_offset_drift",
                       .subject = name_of_joint(joint) + " " + channel.symbol,
                       .joint = joint,
                       .channel = channel,
                       .reference = mean};
        drift.turns_rad = kRadPerArcsec * (values.array() - mean).matrix();
        drift.driver = values;
        drift.typical = kDrift_arcsec_per_k;
        drift.of_noise = kDriftOfNoise;
        result_.causes.push_back(std::move(drift));
      }
    }
    if (!any) missing("joint_offset_drift", "no temperature changes by 0.5 K");
  }

  ArmCatalogue take() { return std::move(result_); }

 private:
  void missing(std::string cause, std::string why) {
    for (auto& one : result_.not_testable)
      if (one.cause == cause) {
        one.why += "; " + why;
        return;
      }
    result_.not_testable.push_back({std::move(cause), std::move(why)});
  }

  const Dataset& dataset_;
  const std::vector<std::size_t>& rows_;
  const KinematicsDescription& arm_;
  Eigen::MatrixXd angles_rad_;  // every row
  ArmCatalogue result_;
};

}  // namespace

ArmCatalogue arm_causes(const Dataset& dataset, const std::vector<std::size_t>& rows,
                        const KinematicsDescription& arm) {
  Eigen::MatrixXd angles(static_cast<Index>(dataset.rows), static_cast<Index>(arm.links.size()));
  for (std::size_t j = 0; j < arm.links.size(); ++j) {
    const Channel& motor = arm.links[j].motor;
    const auto* column = dataset.find(motor.symbol);
    if (column == nullptr || column->channel.unit != motor.unit) return {};
    const double rad = motor.unit == "deg" ? std::numbers::pi / 180 : 1;
    angles.col(static_cast<Index>(j)) =
        rad * Eigen::Map<const Eigen::VectorXd>(column->values.data(),
                                                static_cast<Index>(column->values.size()));
  }
  Builder builder(dataset, rows, arm, std::move(angles));
  builder.add_gravity();
  builder.add_plays_by_motion();
  builder.add_gears();
  builder.add_drifts();
  return builder.take();
}

void add_to(KinematicsDescription& arm, const ArmCause& cause, const Eigen::VectorXd& amplitude) {
  JointErrors& errors = arm.links[cause.joint].errors;
  if (cause.id == "joint_compliance") {
    (kinematics::has_masses(arm) ? errors.sag_urad_per_newton_m : errors.sag_urad_per_m) +=
        amplitude[0];
  } else if (cause.id == "backlash") {
    if (!cause.by_motion) errors.play_arcsec += amplitude[0];
  } else if (cause.id == "gear_error") {
    (cause.harmonic == 1 ? errors.gear_cos1_arcsec : errors.gear_cos2_arcsec) += amplitude[0];
    (cause.harmonic == 1 ? errors.gear_sin1_arcsec : errors.gear_sin2_arcsec) += amplitude[1];
  } else {
    if (errors.drift_channel.symbol.empty()) errors.drift_from_degC = cause.reference;
    errors.drift_channel = cause.channel;
    errors.drift_arcsec_per_k += amplitude[0];
  }
}

}  // namespace driftwise::diagnosis
