#pragma once
// Answers of a served geometry: motor coordinates for a pose, and the pose of motor coordinates,
// with the model's corrections (errors of an arm's joints at present temperatures) in. The second
// kind of law beside a snapshot's polynomial, to whose motor coordinates its own are added.
//
// Motor coordinates are checked against the forward model before they are given: a pose that is
// missed by more than kMostMiss_nm is refused.
//
// Uncertainty. With f(q, p) the measured pose of motor coordinates q and parameters p, J = df/dq
// and A = df/dp, the motor coordinates of a wanted pose depend on p by the implicit function
// f(q, p) = pose, and
//
//   C_q = J^-1 (A C_p A' + S) J^-T       JCGM 102:2011 (GUM supplement 2), 6.2.3 and 6.2.4
//
// C_p is the covariance of the identified parameters (source `fit`), S that of what the model does
// not follow (source `residual`): of a serial arm the mean squares of the held-out errors of x, y
// and z. An arm's orientation is not measured, so S has nothing of it: the figure is that of the
// point. Of a geometry that gives motor coordinates J is 1, A = dq/dp and S the polynomial's
// residual. Errors of the joints count as known but for their thermometers' u (`temperatures`): in
// a pose each thermometer counts with the sum of J times the turns of its joints, signs kept.
// A declared error of the instruments, which moved the parameters by dp, makes J^-1 A dp of each
// motor coordinate (from a zero: less that at the zero), which adds to what it did to the terms
// before anything is squared. Without parameters identified there is no uncertainty: nothing is
// invented.
//
// Pure, any thread; allocates.

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/compensation/snapshot.h"
#include "server/compensation/target.h"
#include "server/core/result.h"

namespace driftwise::compensation {

constexpr double kMostMiss_nm = 1;

// Units of motor coordinates: those of motors(), mm, rad or deg.
struct LawAnswer {
  Eigen::VectorXd motors;
  // Variances of the motors in their units squared; empty: not asked for, or not known.
  Eigen::VectorXd fit, residual, temperatures;
  // Of PresentGeometry::errors: motors x errors, in the motors' units, with signs. Empty: none.
  Eigen::MatrixXd systematic = {};
};
struct LawPose {
  std::vector<Variable> variables;
  Eigen::VectorXd pose;  // requests' units
  Eigen::VectorXd u;     // standard uncertainties, likewise; NaN: not known
};

class GeometryLaw {
 public:
  virtual ~GeometryLaw() = default;

  const std::vector<Variable>& needs() const { return needs_; }
  const std::vector<Channel>& motors() const { return motors_; }
  // That errors of joints drift with.
  const std::vector<Channel>& temperatures() const { return temperatures_; }
  // Motor coordinates count from the scales' own zero, not from that of a datum: an arm's joints.
  virtual bool absolute() const = 0;
  // Of a motor in its unit; infinite: none declared.
  virtual std::pair<double, double> limits(std::size_t motor) const = 0;

  // request: every variable of needs() is finite. Errors: those of kinematics::nearest_joints;
  // out_of_range NO_POSE (the geometry does not reach it); failed_precondition MISSING_VALUE (of an
  // arm: where a joint stands was not read, and the request does not say what to be near to).
  // found: empty, or motors of an earlier answer to the request; an arm takes them as they are.
  virtual Result<LawAnswer> motors_of(const TargetRequest& request, const PresentGeometry& present,
                                      bool with_uncertainty,
                                      std::span<const double> found = {}) const = 0;
  // Whether motors_of() searches: milliseconds.
  virtual bool needs_search(const TargetRequest& request, const PresentGeometry& present) const = 0;
  // q: one per motor, without the polynomial's part. Errors: out_of_range NO_POSE.
  virtual Result<LawPose> pose_of(std::span<const double> q,
                                  const PresentGeometry& present) const = 0;

 protected:
  std::vector<Variable> needs_;
  std::vector<Channel> motors_, temperatures_;
};

// model: with a geometry. Errors: those of kinematics::make_mechanism; failed_precondition
// BAD_KINEMATICS (an arm that has neither 3 nor 6 joints; a pose that no target states).
Result<std::shared_ptr<const GeometryLaw>> make_geometry_law(const calibration::Model& model);

}  // namespace driftwise::compensation
