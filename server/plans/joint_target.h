#pragma once
// A joint target: motor coordinates of all robots of a plan for one wanted pose. First the
// predicted parasitic motions are added, step by step and pass by pass where steps wait for one
// another, then each robot's model or blend answers.
//
// compute_joint_target is a pure function of (snapshot, request): no clock, lock, allocation or
// exception, any thread.
//
// Uncertainty of a motor coordinate: the root of the sum of squares of the model's own, of what the
// added terms' uncertainties (of the last pass) make through the model's slopes, and, where two
// models answer, of w (1 - w) |q_f - q_c|; their own are then weighted with w and 1 - w. Where an
// anchored model's shift fades out, f (1 - f) |shift| is one more line.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "server/compensation/target.h"
#include "server/plans/joint_snapshot.h"

namespace driftwise::plans {

constexpr std::size_t kMostJointOutputs = 16, kMostTerms = 16;

struct JointRequest {
  // By robot of the snapshot; the last entry: what was stated without a robot's id.
  std::array<Values, kMostRobots + 1> value{};
  std::array<std::uint32_t, kMostRobots + 1> given{};  // bit per Variable
  bool with_uncertainty = true, show_unreachable = false;
  CellTime now;

  static constexpr std::size_t kNoRobot = kMostRobots;
  void set(std::size_t robot, compensation::Variable variable, double v) {
    value[robot][static_cast<std::size_t>(variable)] = v;
    given[robot] |= compensation::bit(variable);
  }
};

// "ma.rx_arcsec=12", "z_mm": which robot and coordinate a name means. Errors: invalid_argument
// UNKNOWN_NAME (no coordinate in the request's unit, or no such robot).
struct JointName {
  std::size_t robot = JointRequest::kNoRobot;
  compensation::Variable variable = compensation::Variable::x;
};
Result<JointName> joint_name(const JointSnapshot& snapshot, std::string_view name);

enum class AnsweredBy : std::uint8_t { one, fine, coarse, blend };

struct JointTerm {
  std::uint8_t step, output;
  bool added;
  double value, u;  // mm and nm; of an angle arcsec and 1e-6 arcsec
};

// compensation::TargetFlag of one model, and bits of its inputs.
struct ModelFlags {
  std::uint32_t flags = 0;
  std::uint64_t outside = 0, stale = 0, missing = 0;
};

struct JointTarget {
  struct Robot {
    AnsweredBy by = AnsweredBy::one;
    double weight = 1;         // of the fine model
    double difference_nm = 0;  // of the two models, largest of a motor coordinate
    std::uint32_t flags = 0;   // compensation::TargetFlag, of both models and of the limits
    ModelFlags fine, coarse;   // of each that answered
    std::uint32_t unlimited = 0, unreachable = 0;
    std::size_t first = 0, outputs = 0;  // where its motor coordinates stand
    Values pose{};                       // that its models were asked for
  };
  std::size_t robots = 0, outputs = 0, terms = 0;
  std::array<Robot, kMostRobots> robot{};
  // Not set beyond outputs and terms.
  std::array<double, kMostJointOutputs> q_mm, u_nm;
  std::array<JointTerm, kMostTerms> term;
  // Of the steps, by step: flags and bits of the inputs of its model.
  std::array<std::uint32_t, kMostSteps> step_flags{};
  std::array<std::uint64_t, kMostSteps> step_outside{}, step_stale{}, step_missing{};
  // Bits of stated coordinates that no model depends on, as JointRequest::given.
  std::array<std::uint32_t, kMostRobots + 1> ignored{};
  CellTime valid_until;

  compensation::Refusal refusal = compensation::Refusal::none;
  // Of a refusal: the robot (kMostRobots: none), and coordinates of it as bits. ambiguous: several
  // robots have them and the request names none.
  std::size_t refused_robot = kMostRobots;
  std::uint32_t refused = 0;
  bool ambiguous = false;
  double unreachable_mm = 0;
  std::shared_ptr<const Error> why{};  // of Refusal::no_pose

  double u90_nm(std::size_t i) const { return kSigmaToU90 * u_nm[i]; }
  double expanded_nm(std::size_t i) const { return 2.0 * u_nm[i]; }
};

JointTarget compute_joint_target(const JointSnapshot& snapshot,
                                 const JointRequest& request) noexcept;

// Motor coordinates of one robot at a pose as its models give them, without steps, uncertainty and
// refusal. out: one per output. What the band's check differentiates.
void robot_coordinates(const JointSnapshot::Robot& robot, const Values& pose, double* out) noexcept;
void model_coordinates(const compensation::Snapshot& snapshot, const Values& pose,
                       double* out) noexcept;
// Slopes of a model's outputs by one coordinate of the request: mm or arcsec, per mm or per arcsec.
void model_slopes(const compensation::Snapshot& model, const Values& pose,
                  compensation::Variable by, double* out) noexcept;

// "BLENDED(ma),OUTSIDE_DOMAIN(ma.rx_arcsec)", "" when there is none. between: parts several names
// of one flag. Allocates only where out lacks the room.
void append_joint_flags(std::string& out, const JointSnapshot& snapshot, const JointTarget& target,
                        char between);

// For the edges: these allocate. "OUTSIDE_DOMAIN(ma.rx_arcsec)", "BLENDED(ma)", one text each.
std::vector<std::string> describe_joint_flags(const JointSnapshot& snapshot,
                                              const JointTarget& target);
Error joint_refusal_error(const JointSnapshot& snapshot, const JointTarget& target);
std::string joint_channel(const JointSnapshot& snapshot, const JointTarget& target,
                          std::size_t output);  // "ma.q1_mm"

}  // namespace driftwise::plans
