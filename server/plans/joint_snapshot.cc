#include "server/plans/joint_snapshot.h"

namespace driftwise::plans {

std::optional<std::size_t> JointSnapshot::robot_index(std::string_view id) const {
  for (std::size_t i = 0; i < robots.size(); ++i)
    if (robots[i].id == id) return i;
  return std::nullopt;
}

}  // namespace driftwise::plans
