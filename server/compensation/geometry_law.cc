#include "server/compensation/geometry_law.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/kinematics/angles.h"
#include "server/kinematics/arm_inverse.h"
#include "server/kinematics/delta.h"
#include "server/kinematics/frame.h"
#include "server/kinematics/joint_errors.h"
#include "server/kinematics/mechanism.h"
#include "server/kinematics/serial_arm.h"

namespace driftwise::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSigmasOfA90 = kSigmaToU90;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double wanted(const TargetRequest& request, Variable variable) {
  return request.value[static_cast<std::size_t>(variable)];
}

tl::unexpected<Error> missed(double miss_nm) {
  return fail(ErrorCode::out_of_range, reasons::kNoPose,
              "the forward model misses the pose by " + digits_text(miss_nm, 3) +
                  " nm at the motor coordinates found, more than " + digits_text(kMostMiss_nm, 3) +
                  " nm: not given; ask for a pose farther from the edge of the reach");
}

// Places of the model's free parameters among those of the mechanism; -1: nowhere.
std::vector<Index> free_places(const calibration::Geometry& geometry,
                               const kinematics::Parameters& parameters) {
  std::vector<Index> place;
  for (const auto& one : geometry.parameters) {
    if (!one.free) continue;
    const auto found = std::ranges::find(parameters, one.name, &kinematics::Parameter::name);
    place.push_back(found == parameters.end() ? -1 : found - parameters.begin());
  }
  return place;
}

// Covariance of all parameters of the mechanism; those that are held have none. Empty: not known.
MatrixXd parameter_covariance(const calibration::Geometry& geometry,
                              const kinematics::Parameters& parameters) {
  if (geometry.covariance.size() == 0) return {};
  const auto size = static_cast<Index>(parameters.size());
  const auto place = free_places(geometry, parameters);
  MatrixXd all = MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < place.size(); ++i)
    for (std::size_t j = 0; j < place.size(); ++j)
      if (place[i] >= 0 && place[j] >= 0)
        all(place[i], place[j]) = geometry.covariance(static_cast<Index>(i), static_cast<Index>(j));
  return all;
}

// Shifts of all parameters of the mechanism by each of the declared errors, side by side.
MatrixXd shifts_of(const PresentGeometry& present, const std::vector<Index>& free,
                   Index parameters) {
  MatrixXd all = MatrixXd::Zero(parameters, static_cast<Index>(present.errors.size()));
  for (std::size_t e = 0; e < present.errors.size(); ++e) {
    const auto& shift = present.errors[e].shift;
    for (std::size_t k = 0; k < shift.size() && k < free.size(); ++k)
      if (free[k] >= 0) all(free[k], static_cast<Index>(e)) = shift[k];
  }
  return all;
}

VectorXd variances(const MatrixXd& slopes, const MatrixXd& covariance) {
  return (slopes * covariance).cwiseProduct(slopes).rowwise().sum();
}

// Motor coordinates in closed form from the pose: a delta, a linear axis.
class DirectLaw final : public GeometryLaw {
 public:
  DirectLaw(const calibration::Geometry& geometry,
            std::shared_ptr<const kinematics::Mechanism> mechanism)
      : mechanism_(std::move(mechanism)),
        delta_(dynamic_cast<const kinematics::Delta*>(mechanism_.get())),
        values_(kinematics::nominal_values(mechanism_->parameters())),
        free_(free_places(geometry, mechanism_->parameters())),
        covariance_(parameter_covariance(geometry, mechanism_->parameters())) {
    motors_ = mechanism_->outputs();
    for (const auto& channel : mechanism_->inputs())
      needs_.push_back(*variable_from(channel.symbol));
  }

  bool absolute() const override { return false; }
  std::pair<double, double> limits(std::size_t) const override {
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  }

  bool needs_search(const TargetRequest&, const PresentGeometry&) const override { return false; }

  Result<LawAnswer> motors_of(const TargetRequest& request, const PresentGeometry& present,
                              bool with_uncertainty, std::span<const double>) const override {
    VectorXd pose(static_cast<Index>(needs_.size()));
    for (std::size_t i = 0; i < needs_.size(); ++i)
      pose[static_cast<Index>(i)] = wanted(request, needs_[i]);
    const bool slopes = with_uncertainty && covariance_.size() > 0;
    const auto at = predict(pose, slopes);
    if (!at.value.allFinite())
      return fail(ErrorCode::out_of_range, reasons::kNoPose,
                  "the arms do not reach this pose: ask for one within the workspace");
    DRIFTWISE_TRY(const auto back, forward(at.value));
    const double miss_nm = kNmPerMm * (back - pose).norm();
    if (!(miss_nm <= kMostMiss_nm)) return missed(miss_nm);
    LawAnswer answer;
    answer.motors = at.value;
    MatrixXd by_parameters = at.jacobian;
    if (present.from_zero) {
      const auto zero = predict(VectorXd::Zero(pose.size()), slopes);
      answer.motors -= zero.value;
      by_parameters -= zero.jacobian;
    }
    if (!slopes) return answer;
    answer.fit = variances(by_parameters, covariance_);
    const MatrixXd shifts = shifts_of(present, free_, by_parameters.cols());
    answer.systematic.resize(by_parameters.rows(), shifts.cols());
    for (Index e = 0; e < shifts.cols(); ++e)
      answer.systematic.col(e) =
          (present.errors[static_cast<std::size_t>(e)].shared_with_zero ? by_parameters
                                                                        : MatrixXd(at.jacobian)) *
          shifts.col(e);
    return answer;
  }

  Result<LawPose> pose_of(std::span<const double> q,
                          const PresentGeometry& present) const override {
    VectorXd motors = Eigen::Map<const VectorXd>(q.data(), static_cast<Index>(q.size()));
    if (present.from_zero) motors += predict(VectorXd::Zero(motors.size()), false).value;
    DRIFTWISE_TRY(auto pose, forward(motors));
    LawPose result{needs_, std::move(pose), VectorXd::Constant(motors.size(), kUnknown)};
    return result;
  }

 private:
  kinematics::Prediction predict(const VectorXd& pose, bool slopes) const {
    return mechanism_->predict({pose.data(), static_cast<std::size_t>(pose.size())}, values_,
                               slopes ? kinematics::Derivatives::yes : kinematics::Derivatives::no);
  }

  // A delta by three spheres; a linear axis by its slope.
  Result<VectorXd> forward(const VectorXd& motors) const {
    if (delta_ != nullptr) {
      DRIFTWISE_TRY(const auto pose, delta_->pose_from_motor(motors, values_));
      return VectorXd(pose);
    }
    const double at_0 = predict(VectorXd::Zero(1), false).value[0];
    const double at_1 = predict(VectorXd::Ones(1), false).value[0];
    return VectorXd(VectorXd::Constant(1, (motors[0] - at_0) / (at_1 - at_0)));
  }

  std::shared_ptr<const kinematics::Mechanism> mechanism_;
  const kinematics::Delta* delta_;  // the same; null: another kind
  VectorXd values_;
  std::vector<Index> free_;
  MatrixXd covariance_;
};

class ArmLaw final : public GeometryLaw {
 public:
  ArmLaw(const calibration::Model& model, kinematics::SerialArm arm)
      : arm_(std::move(arm)),
        values_(kinematics::nominal_values(arm_.parameters())),
        free_(free_places(*model.geometry, arm_.parameters())),
        covariance_(parameter_covariance(*model.geometry, arm_.parameters())) {
    for (std::size_t j = 0; j < arm_.joints(); ++j) motors_.push_back(arm_.inputs()[j]);
    temperatures_.assign(arm_.inputs().begin() + static_cast<std::ptrdiff_t>(arm_.joints()),
                         arm_.inputs().end());
    needs_ = {Variable::x, Variable::y, Variable::z};
    if (arm_.joints() != 3) needs_.insert(needs_.end(), {Variable::rx, Variable::ry, Variable::rz});
    // Errors of each coordinate on rows that the model was not fitted to.
    for (const auto& output : model.outputs) {
      const auto& figures = output.accuracy;
      const double a90 =
          figures.a90_validation.value_or(figures.a90_blocks.value_or(figures.a90_calibration));
      const double mm = mm_from_nm(summary_unit(output.channel.unit).factor) * a90 / kSigmasOfA90;
      for (Index k = 0; k < 3; ++k)
        if (output.channel.symbol == std::string(1, "xyz"[k])) residual_mm2_[k] = mm * mm;
    }
  }

  bool absolute() const override { return true; }
  std::pair<double, double> limits(std::size_t motor) const override {
    const auto& link = arm_.description().links[motor];
    const double unit_per_deg = kinematics::kRadPerDeg / arm_.rad_per_unit(motor);
    return {link.min_deg * unit_per_deg, link.max_deg * unit_per_deg};
  }

  bool needs_search(const TargetRequest& request, const PresentGeometry& present) const override {
    const auto near = nearest_to(request, present);
    return near && kinematics::needs_search(arm_, values_, pose_wanted(request), *near,
                                            present.temperatures);
  }

  Result<LawAnswer> motors_of(const TargetRequest& request, const PresentGeometry& present,
                              bool with_uncertainty, std::span<const double> found) const override {
    std::vector<double> joints(found.begin(), found.end());
    if (joints.empty()) {
      DRIFTWISE_TRY(const auto near, nearest_to(request, present));
      DRIFTWISE_TRY(auto nearest, kinematics::nearest_joints(arm_, values_, pose_wanted(request),
                                                             near, present.temperatures,
                                                             kinematics::Search::until_certain));
      if (!(nearest.miss_nm <= kMostMiss_nm)) return missed(nearest.miss_nm);
      joints = std::move(nearest.joints);
    }
    LawAnswer answer;
    answer.motors = Eigen::Map<const VectorXd>(joints.data(), static_cast<Index>(joints.size()));
    if (with_uncertainty && covariance_.size() > 0) add_uncertainty(joints, present, answer);
    return answer;
  }

  Result<LawPose> pose_of(std::span<const double> q,
                          const PresentGeometry& present) const override {
    const auto at = posture(q, present, kinematics::Derivatives::yes);
    const VectorXd placed = kinematics::frame_values(at.tool.linear(), at.tool.translation());
    LawPose result{needs_, placed.head(static_cast<Index>(needs_.size())), {}};
    for (Index k = 3; k < result.pose.size(); ++k)
      result.pose[k] = arcsec_from_rad(kinematics::rad_from_deg(result.pose[k]));
    result.u = VectorXd::Constant(result.pose.size(), kUnknown);
    if (covariance_.size() > 0)  // of the point; nothing measured the axes
      result.u.head<3>() =
          (variances(at.by_parameters.topRows<3>(), covariance_) + residual_mm2_ +
           temperature_variances(at, present) +
           (at.by_parameters.topRows<3>() * shifts_of(present, free_, at.by_parameters.cols()))
               .rowwise()
               .squaredNorm())
              .cwiseSqrt();
    return result;
  }

 private:
  static double deg(const TargetRequest& request, Variable variable) {
    return kinematics::deg_from_rad(rad_from_arcsec(wanted(request, variable)));
  }

  kinematics::WantedPose pose_wanted(const TargetRequest& request) const {
    kinematics::WantedPose pose{
        {wanted(request, Variable::x), wanted(request, Variable::y), wanted(request, Variable::z)},
        {}};
    if (arm_.joints() == 3) return pose;
    Eigen::Matrix<double, kinematics::kFrameParameters, 1> frame;
    frame << 0, 0, 0, deg(request, Variable::rx), deg(request, Variable::ry),
        deg(request, Variable::rz);
    pose.axes = kinematics::Frame(frame).rotation();
    return pose;
  }

  kinematics::SerialArm::Posture posture(std::span<const double> q, const PresentGeometry& present,
                                         kinematics::Derivatives by_parameters) const {
    std::vector<double> inputs(q.begin(), q.end());
    inputs.insert(inputs.end(), present.temperatures.begin(), present.temperatures.end());
    return arm_.posture(inputs, values_, by_parameters);
  }

  // Stated, or where the joint stands.
  Result<std::vector<double>> nearest_to(const TargetRequest& request,
                                         const PresentGeometry& present) const {
    std::vector<double> near;
    for (std::size_t j = 0; j < arm_.joints(); ++j) {
      // By the number in its name: q1 is the first that a request knows.
      const auto number = static_cast<std::size_t>(std::atoi(motors_[j].symbol.c_str() + 1));
      const bool stated = number >= 1 && number <= kMaxJoints && (request.near >> (number - 1) & 1);
      near.push_back(stated ? request.near_rad[number - 1] / arm_.rad_per_unit(j)
                            : present.standing[j]);
      if (!std::isfinite(near.back()))
        return fail(ErrorCode::failed_precondition, reasons::kMissingValue,
                    motors_[j].name() +
                        " was not read, so which of the arm's solutions is nearest is not known: "
                        "state the angle to be near to (driftwise target ... --near " +
                        motors_[j].name() + "=...)");
    }
    return near;
  }

  void add_uncertainty(std::span<const double> q, const PresentGeometry& present,
                       LawAnswer& answer) const {
    const auto rows = static_cast<Index>(needs_.size());
    const auto at = posture(q, present, kinematics::Derivatives::yes);
    // A turn times the reach stands beside the point's motion, so that the inverse is well scaled.
    const double reach_mm = arm_.reach_mm();
    MatrixXd by_joints = at.jacobian.topRows(rows), by_parameters = at.by_parameters.topRows(rows);
    if (rows == 6) {
      by_joints.bottomRows(3) *= reach_mm;
      by_parameters.bottomRows(3) *= reach_mm;
    }
    MatrixXd inverse = by_joints.inverse();  // rad per mm
    for (Index j = 0; j < inverse.rows(); ++j)
      inverse.row(j) /= arm_.rad_per_unit(static_cast<std::size_t>(j));
    answer.fit = variances(inverse * by_parameters, covariance_);
    answer.systematic = inverse * by_parameters * shifts_of(present, free_, by_parameters.cols());
    answer.residual = inverse.leftCols(3).cwiseAbs2() * residual_mm2_;
    answer.temperatures = VectorXd::Zero(rows);
    for (Index j = 0; j < rows; ++j) {
      const auto joint = static_cast<std::size_t>(j);
      for (std::size_t c = 0; c < temperatures_.size(); ++c) {
        const double turn = drift_rad(joint, c, present) / arm_.rad_per_unit(joint);
        answer.temperatures[j] += turn * turn;
      }
    }
  }

  // Turn of a joint by the standard uncertainty of a thermometer; 0: it drifts with another.
  double drift_rad(std::size_t joint, std::size_t channel, const PresentGeometry& present) const {
    const auto& errors = arm_.description().links[joint].errors;
    if (errors.drift_channel != temperatures_[channel]) return 0;
    return rad_from_arcsec(errors.drift_arcsec_per_k) * present.u_temperatures[channel];
  }

  // Of x, y, z. One thermometer turns its joints together, with their signs.
  Eigen::Vector3d temperature_variances(const kinematics::SerialArm::Posture& at,
                                        const PresentGeometry& present) const {
    Eigen::Vector3d variance = Eigen::Vector3d::Zero();
    for (std::size_t c = 0; c < temperatures_.size(); ++c) {
      Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();
      for (std::size_t j = 0; j < arm_.joints(); ++j)
        moved_mm += drift_rad(j, c, present) * at.jacobian.col(static_cast<Index>(j)).head<3>();
      variance += moved_mm.cwiseAbs2();
    }
    return variance;
  }

  kinematics::SerialArm arm_;
  VectorXd values_;
  std::vector<Index> free_;
  MatrixXd covariance_;
  Eigen::Vector3d residual_mm2_ = Eigen::Vector3d::Zero();
};

}  // namespace

bool may_search(const Snapshot& snapshot) noexcept {
  return snapshot.geometry && snapshot.geometry->law->absolute();
}

Result<std::shared_ptr<const GeometryLaw>> make_geometry_law(const calibration::Model& model) {
  const auto& robot = model.geometry->robot;
  if (robot.kind == "serial-arm") {
    DRIFTWISE_TRY(auto arm, kinematics::SerialArm::create(robot));
    if (arm.joints() != 3 && arm.joints() != 6)
      return fail(ErrorCode::failed_precondition, reasons::kBadKinematics,
                  "found " + std::to_string(arm.joints()) +
                      " joints: targets need 3 (a point) or 6 (a point and axes)");
    return std::make_shared<const ArmLaw>(model, std::move(arm));
  }
  DRIFTWISE_TRY(auto mechanism, kinematics::make_mechanism(robot));
  for (const auto& channel : mechanism->inputs())
    if (const auto variable = variable_from(channel.symbol);
        !variable || channel_of(*variable) != channel)
      return fail(ErrorCode::failed_precondition, reasons::kBadKinematics,
                  "the geometry reads " + channel.name() +
                      ", expected coordinates that a target states, such as x_mm");
  return std::make_shared<const DirectLaw>(*model.geometry, std::move(mechanism));
}

}  // namespace driftwise::compensation
