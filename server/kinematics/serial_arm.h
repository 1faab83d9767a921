#pragma once
// A serial arm by Denavit and Hartenberg, joint angles -> measured point. The chain, base first:
//
//   frame . prod_i [ Rz(theta_i + q_i) Tz(d_i) Tx(a_i) Rx(alpha_i) Ry(beta_i) ] . tool
//
// Where a link's axis and the next are nearly parallel (alpha within 5 degrees of 0 or 180) the
// common normal, and with it d, jumps for the smallest misalignment. There Hayati's form is
// identified: beta_i turns about y, d_i stays nominal. Elsewhere beta_i stays nominal and d_i is
// identified.
//
// References: J. Denavit, R. Hartenberg, J. Appl. Mech. 22 (1955) 215; S. Hayati, Proc. 22nd IEEE
// Conf. on Decision and Control (1983) 1477; J. M. Hollerbach, C. W. Wampler, Int. J. Robotics
// Research 15 (1996) 573 on the number of identifiable parameters.

// Errors of the joints beyond the drawing (joint_errors.h) turn each joint by what they give at the
// angles read back; temperatures that they read are inputs behind the joints.

#include <Eigen/Geometry>

#include "server/kinematics/mechanism.h"

namespace driftwise::kinematics {

class SerialArm final : public Mechanism {
 public:
  static Result<SerialArm> create(const KinematicsDescription& description);

  std::size_t joints() const { return rad_per_unit_.size(); }
  double rad_per_unit(std::size_t joint) const { return rad_per_unit_[joint]; }
  double reach_mm() const { return reach_mm_; }

  struct Posture {
    Eigen::Isometry3d tool;  // in the measuring frame: the point, and the last link's axes
    // 6 x joints: the point's motion, mm per rad, and the turn, rad per rad, of each joint alone.
    // The errors of the joints count as constant.
    Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian;
    // The same by each parameter of the drawing, per its unit.
    Eigen::Matrix<double, 6, Eigen::Dynamic> by_parameters;
  };
  // inputs, values: as for predict().
  Posture posture(std::span<const double> inputs, const Eigen::VectorXd& values,
                  Derivatives by_parameters = Derivatives::no) const;

  // Frames that stand still between two joints: from the measuring frame to the first joint, from
  // each joint to the next, behind the last to the tool. Each joint turns about z in between, by
  // its angle and its errors. values: as for predict().
  std::vector<Eigen::Isometry3d> between_joints(const Eigen::VectorXd& values) const;

 private:
  using Mechanism::Mechanism;
  // q1.. (rad or deg, as the channels say) -> x, y, z (mm).
  Prediction evaluate(std::span<const double> inputs, const Eigen::VectorXd& values,
                      Derivatives derivatives) const override;

  enum class Kind { turn, shift };
  struct Element {  // of the chain: about or along one axis of the frame reached so far
    Kind kind;
    int axis;       // 0 x, 1 y, 2 z
    int parameter;  // -1: fixed
    double fixed;   // where it is
    int joint;      // whose angle is added, -1: none
  };
  // Angle or way of each element. inputs, values: as for predict().
  std::vector<double> motions(std::span<const double> inputs, const Eigen::VectorXd& values) const;

  std::vector<Element> chain_;
  std::vector<double> rad_per_unit_;  // of each joint
  double reach_mm_ = 1;               // stretched out
  bool has_errors_ = false;
};

}  // namespace driftwise::kinematics
