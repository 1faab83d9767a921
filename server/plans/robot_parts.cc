#include "server/plans/robot_parts.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/effects/term_order.h"

namespace driftwise::plans {
namespace {

bool is_robots(std::string_view symbol) {
  const std::string_view local = without_robot(symbol);
  return is_motor_symbol(local) || is_pose_symbol(local);
}

std::string stripped(const std::string& name, const std::string& robot) {
  return !robot.empty() && robot_of(name) == robot ? std::string(without_robot(name)) : name;
}

void strip(effects::Term& term, const std::string& robot) {
  for (auto& factor : term.factors) {
    if (auto* power = std::get_if<effects::Power>(&factor)) {
      power->symbol = stripped(power->symbol, robot);
      continue;
    }
    for (auto& symbol : std::get<effects::Call>(factor).symbols) symbol = stripped(symbol, robot);
  }
}

// A robot without an id owns the names without one.
bool is_of(const std::string& symbol, const std::string& robot) {
  return !is_robots(symbol) || robot_of(symbol) == robot;
}

}  // namespace

std::set<std::string> robots_of(const calibration::Model& model) {
  std::set<std::string> found;
  const auto see = [&found](const std::string& symbol) {
    if (is_robots(symbol)) found.emplace(robot_of(symbol));
  };
  for (const auto& output : model.outputs) {
    see(output.channel.symbol);
    for (const auto& term : output.terms)
      for (const auto& symbol : effects::symbols_of(term)) see(symbol);
  }
  return found;
}

Result<calibration::Model> part_of_robot(calibration::Model model, const std::string& robot) {
  for (const auto& other : robots_of(model)) {
    if (other == robot) continue;
    const auto remedy = [](const std::string& found) {
      return found.empty() ? "in a cell with one robot leave id out of [[robot]]; with several, "
                             "name a model whose channels carry the robot's id, as in ma.q1_mm"
                           : "name a model of that robot (its channels carry the robot's id, as in "
                             "ma.q1_mm)";
    };
    const auto called = [](const std::string& id) {
      return id.empty() ? std::string("a robot without an id") : "robot " + shown(id);
    };
    return fail(ErrorCode::failed_precondition, reasons::kOtherRobot,
                "the model has channels of " + called(other) + ", the plan uses it for " +
                    called(robot) + ": " + remedy(other));
  }
  for (auto& output : model.outputs) {
    output.channel.symbol = stripped(output.channel.symbol, robot);
    for (auto& term : output.terms) strip(term, robot);
    for (auto& influence : output.influences) {
      influence.channel = stripped(influence.channel, robot);
      influence.by = stripped(influence.by, robot);
    }
  }
  for (auto& range : model.domain) range.channel.symbol = stripped(range.channel.symbol, robot);
  for (auto& zero : model.datum_zeros)
    for (auto& value : zero.pose) value.channel = stripped(value.channel, robot);
  auto& measured_by = model.lineage.measured_by;
  std::erase_if(measured_by, [&robot](const auto& one) { return !is_of(one.symbol, robot); });
  for (auto& coordinate : measured_by) coordinate.symbol = stripped(coordinate.symbol, robot);
  return model;
}

CellDescription part_of_robot(CellDescription cell, const std::string& robot) {
  const auto foreign = [&robot](const auto& one) { return !is_of(one.channel.symbol, robot); };
  const auto strip_all = [&robot](auto& list) {
    for (auto& one : list) one.channel.symbol = stripped(one.channel.symbol, robot);
  };
  for (auto& device : cell.devices) {
    if (auto* motion = std::get_if<MotionSettings>(&device.settings)) {
      std::erase_if(motion->axes, foreign);
      strip_all(motion->axes);
    }
    if (auto* angles = std::get_if<AngleSettings>(&device.settings)) {
      std::erase_if(angles->angles, foreign);
      strip_all(angles->angles);
    }
  }
  // A length has one channel: a device of another robot goes as a whole.
  std::erase_if(cell.devices, [&](const DeviceDescription& device) {
    const auto* length = device.length();
    return length && !is_of(length->channel.symbol, robot);
  });
  for (auto& device : cell.devices)
    if (auto* length = std::get_if<LengthSettings>(&device.settings))
      length->channel.symbol = stripped(length->channel.symbol, robot);
  if (cell.correction) {
    auto& beams = cell.correction->beams;
    std::erase_if(beams, [&](const auto& beam) { return !is_of(beam.length.symbol, robot); });
    for (auto& beam : beams) beam.length.symbol = stripped(beam.length.symbol, robot);
  }
  return cell;
}

std::vector<ChannelValue> part_of_robot(std::span<const ChannelValue> values,
                                        const std::string& robot) {
  std::vector<ChannelValue> out;
  for (const auto& value : values) {
    const std::string symbol = value.channel.substr(0, value.channel.rfind('_'));
    if (!is_of(symbol, robot)) continue;
    out.push_back(value);
    out.back().channel = stripped(value.channel, robot);
  }
  return out;
}

}  // namespace driftwise::plans
