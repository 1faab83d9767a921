#pragma once
// Places: visits of one commanded position of all motors together.

#include <vector>

#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

struct MotorPlaces {
  std::vector<std::vector<double>> places;  // coordinates, scaled alike; of the pose without motors
  std::vector<std::size_t> of_block;        // empty: no coordinate varies
};

MotorPlaces motor_places(const Problem& problem);

}  // namespace driftwise::diagnosis
