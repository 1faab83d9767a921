#pragma once
// The correction stage of a cell: what its interferometers and autocollimators read -> pose.
//
// Rotations of a pose are those since the datum's zero, like its lengths: an autocollimator's own
// zero is where somebody screwed it down. What the devices read stays under their own channels in
// the stored readings; beside a corrected x_mm stands the raw path x_path_mm. Executor's thread.

#include <string>
#include <vector>

#include "server/core/data/reading.h"
#include "server/core/description/cell_description.h"
#include "server/correction/correction.h"

namespace driftwise::application {

class PoseStage {
 public:
  explicit PoseStage(const CellDescription& description);

  // Its rectifications are applied from now on, and coordinates that it does not name are left
  // out; nullptr: none. setup: outlives its use.
  void use(const SetupDescription* setup) { setup_ = setup; }

  // Nothing to do: no [correction], no rotation is measured, nothing is rectified.
  bool is_identity() const { return !corrects_ && angles_.empty() && !setup_; }

  // values: a datum's, with the rotations as the devices read them at the zero. Rotations that are
  // not among them count from 0.
  void set_zero(const std::vector<ChannelValue>& values);

  // The second reading of a rotation that a set-up has confirmed counts from the zero as well
  // (rz_confirmed_arcsec); beside it stands its difference to the first (rz_difference_arcsec).
  //
  // raw: values under the devices' channels, means of several or of one round. In the result x_mm
  // .. are pose, x_path_mm .. the raw paths, rotations count from the zero, everything else is as
  // it was. A length that a raw value is missing for is left out.
  std::vector<ChannelValue> pose(const std::vector<ChannelValue>& raw) const;

  // The same reading under the names that live values have: x_path_mm for a corrected length,
  // ry_raw_arcsec for a rotation as the device gives it.
  Reading under_raw_names(Reading reading) const;

 private:
  std::string raw_name(const std::string& channel) const;
  std::vector<ChannelValue> rectified(std::vector<ChannelValue> values) const;
  void add_confirmations(const std::vector<ChannelValue>& raw,
                         std::vector<ChannelValue>& out) const;

  // Its rotations correct its own lengths only.
  struct RobotStage {
    std::string robot;  // empty: the cell's only one
    correction::Stage stage;
    correction::Tilt zero;
  };
  // Of the robot's channels among these values.
  correction::Tilt tilt_of(const std::string& robot, const std::vector<ChannelValue>& values) const;

  std::vector<Channel> lengths_, paths_, angles_;
  std::vector<RobotStage> robots_;
  bool corrects_ = false;
  const SetupDescription* setup_ = nullptr;
  std::vector<ChannelValue> confirmed_zero_;  // as the second instruments read them at the zero
};

}  // namespace driftwise::application
