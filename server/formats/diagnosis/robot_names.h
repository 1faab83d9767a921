#pragma once
// Names of one robot's channels in a cell with several: with the robot's id outside ("ma.q1",
// "ma.x_mm"), without it in the rooms that work on one robot ("q1", "x_mm"). A diagnosis looks at
// one robot's part of a dataset: its coordinates under their bare names, temperatures as they are,
// and the coordinates of the other robots, which keep their ids, as further channels.

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/correction/data_amendment.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::formats {

class RobotNames {
 public:
  // robot: "ma"; empty: the only robot of its cell, every name stays as it is.
  RobotNames(const Dataset& dataset, std::string robot);

  const std::string& robot() const { return robot_; }

  // A symbol, a formula, a term, a sentence or a trajectory: every name of the robot's channels in
  // it, alone between other characters, loses or gets the id.
  std::string bare(std::string_view text) const;
  std::string with_id(std::string_view text) const;

  Dataset bare(Dataset dataset) const;
  diagnosis::Diagnosis bare(diagnosis::Diagnosis found) const;
  diagnosis::Diagnosis with_id(diagnosis::Diagnosis found) const;
  correction::DataAmendment with_id(correction::DataAmendment amendment) const;
  Error with_id(Error error) const;

 private:
  std::string robot_;
  std::set<std::string, std::less<>> own_;  // bare symbols and channel names, "q" for all motors
};

// Ids of the robots whose coordinates the dataset has; none: a cell with one robot.
std::set<std::string> robots_in(const Dataset& dataset);

// The robot that a diagnosis of this dataset is of: the one asked for ("": none is), the one that
// the outputs of the formula name, or the only one there is. "": a cell with one robot.
// Errors: invalid_argument OTHER_ROBOT (not in the data; another than the formula's; outputs of
// several), AMBIGUOUS_COORDINATE (several robots, and none is named).
Result<std::string> robot_asked_for(const Dataset& dataset, std::string_view formula,
                                    const std::string& asked);

// "ma" of "ma.q ~ ..."; empty: the outputs name no robot.
std::string robot_of_formula(std::string_view formula);

}  // namespace driftwise::formats
