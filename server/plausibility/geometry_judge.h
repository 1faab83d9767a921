#pragma once
// The measured pose against the readback, by the geometry that the cell file declares. Pure.
//
// The declared geometry is a drawing: its error, the robot's and the load's bending are far below
// the limits ([plausibility] geometry_um, geometry_pct), a length that does not follow the axis is
// far above. The fitted and the served model are not asked: a robot that changed is no instrument
// that lies.

#include <memory>
#include <string>
#include <vector>

#include "server/core/data/reading.h"
#include "server/core/description/cell_description.h"
#include "server/kinematics/mechanism.h"

namespace driftwise::plausibility {

// What does not follow, per output of the mechanism; empty: everything does.
struct GeometryComparison {
  struct Output {
    Channel channel;
    double off_mm = 0, limit_mm = 0;  // or degrees: the output's unit
  };
  std::vector<Output> outputs;
  bool disagrees() const;
  // "q1_mm by the pose is 2.000 mm from its readback, the declared geometry allows 0.040 mm: ..."
  std::string sentence() const;
};

class GeometryJudge {
 public:
  // With several robots each by its own [robot.kinematics]. Without [kinematics], or where the cell
  // does not measure what the mechanism needs, nothing is compared: knows() is false.
  explicit GeometryJudge(const CellDescription& cell);

  bool knows() const { return !robots_.empty(); }
  // pose: x_mm .. since the datum's zero; q: as read back; q_zero: the same where the pose is 0.
  // What a value is missing for is left out.
  GeometryComparison compare(const std::vector<ChannelValue>& pose,
                             const std::vector<ChannelValue>& q,
                             const std::vector<ChannelValue>& q_zero) const;

 private:
  const PlausibilityRules rules_;
  struct Robot {
    std::string prefix;  // "ma." before its channels; empty: the cell's only robot
    std::shared_ptr<const kinematics::Mechanism> mechanism;
    Eigen::VectorXd values;
  };
  void add(const KinematicsDescription& geometry, const std::string& prefix);
  void compare(const Robot& robot, const std::vector<ChannelValue>& pose,
               const std::vector<ChannelValue>& q, const std::vector<ChannelValue>& q_zero,
               GeometryComparison& comparison) const;

  std::vector<Robot> robots_;
};

}  // namespace driftwise::plausibility
