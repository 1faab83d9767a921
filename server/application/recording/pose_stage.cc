#include "server/application/recording/pose_stage.h"

#include <algorithm>

#include "server/correction/described_stage.h"

namespace driftwise::application {
namespace {

const double* value_of(const std::vector<ChannelValue>& values, const std::string& channel) {
  const auto found = std::ranges::find(values, channel, &ChannelValue::channel);
  return found == values.end() || is_missing(found->value) ? nullptr : &found->value;
}

// x 0, y 1, z 2; "rx" likewise.
std::size_t axis_of(const std::string& symbol) {
  return static_cast<std::size_t>(symbol.back() - 'x');
}

double& component(correction::Tilt& tilt, std::size_t axis) {
  return axis == 0 ? tilt.rx_arcsec : axis == 1 ? tilt.ry_arcsec : tilt.rz_arcsec;
}

}  // namespace

PoseStage::PoseStage(const CellDescription& description)
    : lengths_(description.length_channels()),
      paths_(description.path_channels()),
      angles_(description.angle_channels()),
      corrects_(description.correction.has_value()) {
  std::vector<Channel> all = lengths_;
  all.insert(all.end(), angles_.begin(), angles_.end());
  for (const auto& channel : all) {
    const std::string robot(robot_of(channel.symbol));
    if (std::ranges::find(robots_, robot, &RobotStage::robot) != robots_.end()) continue;
    auto& one = robots_.emplace_back(RobotStage{robot, {}, {}});
    if (corrects_) one.stage = correction::stage_from(*description.correction, robot);
  }
}

correction::Tilt PoseStage::tilt_of(const std::string& robot,
                                    const std::vector<ChannelValue>& values) const {
  correction::Tilt tilt;
  for (const auto& angle : angles_)
    if (robot_of(angle.symbol) == robot)
      if (const double* arcsec = value_of(values, angle.name()))
        component(tilt, axis_of(angle.symbol)) = *arcsec;
  return tilt;
}

std::vector<ChannelValue> PoseStage::rectified(std::vector<ChannelValue> values) const {
  if (!setup_) return values;
  const auto& wanted = setup_->coordinates;
  const auto is_coordinate = [](const std::vector<Channel>& channels, const std::string& name) {
    return std::ranges::find(channels, name, &Channel::name) != channels.end();
  };
  std::erase_if(values, [&](const ChannelValue& value) {  // what it has beside its coordinates
    return (is_coordinate(lengths_, value.channel) || is_coordinate(angles_, value.channel)) &&
           std::ranges::none_of(wanted, [&value](const SetupCoordinate& coordinate) {
             return coordinate.channel.name() == value.channel;
           });
  });
  for (auto& value : values)
    for (const auto& coordinate : wanted)
      if (coordinate.channel.name() == value.channel)
        value.value = coordinate.scale * value.value + coordinate.offset;
  return values;
}

void PoseStage::set_zero(const std::vector<ChannelValue>& as_read) {
  const auto values = rectified(as_read);
  for (auto& one : robots_) one.zero = tilt_of(one.robot, values);
  confirmed_zero_.clear();
  if (!setup_) return;
  for (const auto& one : setup_->confirmations)
    if (const double* value = value_of(as_read, one.confirmed().name()))
      confirmed_zero_.push_back({one.confirmed().name(), *value});
}

void PoseStage::add_confirmations(const std::vector<ChannelValue>& raw,
                                  std::vector<ChannelValue>& out) const {
  if (!setup_) return;
  for (const auto& one : setup_->confirmations) {
    const std::string name = one.confirmed().name();
    const double* read = value_of(raw, name);
    if (!read) continue;
    const double* zero = value_of(confirmed_zero_, name);
    const double confirmed = one.scale * (*read - (zero ? *zero : 0)) + (zero ? 0 : one.offset);
    std::erase_if(out, [&name](const ChannelValue& value) { return value.channel == name; });
    out.push_back({name, confirmed});
    if (const double* measured = value_of(out, one.channel.name()))
      out.push_back({one.difference().name(), confirmed - *measured});
  }
}

std::vector<ChannelValue> PoseStage::pose(const std::vector<ChannelValue>& as_read) const {
  if (is_identity()) return as_read;
  const auto raw = rectified(as_read);
  std::vector<ChannelValue> poses, rotations;
  for (const auto& one : robots_) {
    auto tilt = tilt_of(one.robot, raw);
    auto zero = one.zero;
    for (const auto& angle : angles_)
      if (robot_of(angle.symbol) == one.robot && value_of(raw, angle.name())) {
        const auto axis = axis_of(angle.symbol);
        component(tilt, axis) -= component(zero, axis);
        rotations.push_back({angle.name(), component(tilt, axis)});
      }
    correction::Vector3 path_mm{};
    for (const auto& length : lengths_)
      if (robot_of(length.symbol) == one.robot)
        if (const double* mm = value_of(raw, length.name())) path_mm[axis_of(length.symbol)] = *mm;
    const auto pose_mm =
        corrects_ ? correction::pose_from_paths(path_mm, tilt, one.stage) : path_mm;
    for (const auto& length : lengths_)
      if (robot_of(length.symbol) == one.robot && value_of(raw, length.name()))
        poses.push_back({length.name(), pose_mm[axis_of(length.symbol)]});
  }

  std::vector<ChannelValue> out;
  for (const auto& length : lengths_)
    if (const double* mm = value_of(poses, length.name())) out.push_back({length.name(), *mm});
  for (const auto& angle : angles_)
    if (const double* arcsec = value_of(rotations, angle.name()))
      out.push_back({angle.name(), *arcsec});
  for (const auto& value : raw) {
    const auto at = std::ranges::find(lengths_, value.channel, &Channel::name);
    if (at != lengths_.end() && corrects_)
      out.push_back({paths_[static_cast<std::size_t>(at - lengths_.begin())].name(), value.value});
    else if (!value_of(out, value.channel) &&
             std::ranges::find(angles_, value.channel, &Channel::name) == angles_.end())
      out.push_back(value);
  }
  add_confirmations(raw, out);
  return out;
}

std::string PoseStage::raw_name(const std::string& channel) const {
  if (corrects_)
    for (std::size_t i = 0; i < lengths_.size(); ++i)
      if (lengths_[i].name() == channel) return paths_[i].name();
  for (const auto& angle : angles_)
    if (angle.name() == channel) return angle.symbol + "_raw_" + angle.unit;
  return channel;
}

Reading PoseStage::under_raw_names(Reading reading) const {
  for (auto& value : reading.values) value.channel = raw_name(value.channel);
  return reading;
}

}  // namespace driftwise::application
