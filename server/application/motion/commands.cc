#include "server/application/motion/commands.h"

#include <algorithm>
#include <utility>

namespace driftwise::application {

void set_commands(const CellDescription& description, std::vector<double> commanded_mm,
                  PointRecord& point) {
  const auto motors = description.motor_channels();
  bool are_counted = true;
  for (std::size_t i = 0; i < motors.size(); ++i)
    are_counted = are_counted && motors[i].symbol == "q" + std::to_string(i + 1);
  for (std::size_t i = 0; !are_counted && i < std::min(motors.size(), commanded_mm.size()); ++i)
    point.values.push_back({motors[i].symbol + "_cmd_" + motors[i].unit, commanded_mm[i]});
  point.commanded_mm = std::move(commanded_mm);
}

}  // namespace driftwise::application
