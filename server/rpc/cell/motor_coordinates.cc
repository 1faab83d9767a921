#include "server/rpc/cell/motor_coordinates.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {

Result<std::vector<double>> motor_coordinates_from(
    const google::protobuf::RepeatedPtrField<v1::ChannelValue>& coordinates,
    const CellDescription& cell) {
  DRIFTWISE_TRY(const auto values, values_from(coordinates, "coordinates"));
  const auto axes = cell.motor_channels();
  std::string known;
  for (const auto& axis : axes) known += (known.empty() ? "" : ", ") + axis.name();
  for (const auto& value : values)
    if (std::none_of(axes.begin(), axes.end(),
                     [&](const Channel& axis) { return axis.name() == value.channel; }))
      return fail(ErrorCode::invalid_argument, reasons::kUnknownAxis,
                  "coordinates: found " + value.channel + ", the axes of this cell are " + known);
  std::vector<double> q_mm;
  for (const auto& axis : axes) {
    const auto found = std::find_if(values.begin(), values.end(), [&](const ChannelValue& value) {
      return value.channel == axis.name();
    });
    const bool is_robot_named =
        !cell.has_several_robots() || std::any_of(values.begin(), values.end(), [&](const auto& v) {
          return robot_of(v.channel) == robot_of(axis.symbol);
        });
    if (found == values.end() && !is_robot_named && !values.empty()) {
      q_mm.push_back(kMissing);
      continue;
    }
    if (found == values.end())
      return fail(
          ErrorCode::invalid_argument, reasons::kMissingCoordinate,
          "coordinates: " + axis.name() + " is missing, a move names every one of " + known);
    q_mm.push_back(found->value);
  }
  return q_mm;
}

}  // namespace driftwise::rpc
