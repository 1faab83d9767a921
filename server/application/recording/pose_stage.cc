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
  if (corrects_) stage_ = correction::stage_from(*description.correction);
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
  zero_ = {};
  const auto values = rectified(as_read);
  for (const auto& angle : angles_)
    if (const double* arcsec = value_of(values, angle.name()))
      component(zero_, axis_of(angle.symbol)) = *arcsec;
}

std::vector<ChannelValue> PoseStage::pose(const std::vector<ChannelValue>& as_read) const {
  if (is_identity()) return as_read;
  const auto raw = rectified(as_read);
  correction::Tilt tilt, zero = zero_;
  for (const auto& angle : angles_)
    if (const double* arcsec = value_of(raw, angle.name())) {
      const auto axis = axis_of(angle.symbol);
      component(tilt, axis) = *arcsec - component(zero, axis);
    }
  correction::Vector3 path_mm{};
  for (const auto& length : lengths_)
    if (const double* mm = value_of(raw, length.name())) path_mm[axis_of(length.symbol)] = *mm;
  const auto pose_mm = corrects_ ? correction::pose_from_paths(path_mm, tilt, stage_) : path_mm;

  std::vector<ChannelValue> out;
  for (const auto& length : lengths_)
    if (value_of(raw, length.name()))
      out.push_back({length.name(), pose_mm[axis_of(length.symbol)]});
  for (const auto& angle : angles_)
    if (value_of(raw, angle.name()))
      out.push_back({angle.name(), component(tilt, axis_of(angle.symbol))});
  for (const auto& value : raw) {
    const auto at = std::ranges::find(lengths_, value.channel, &Channel::name);
    if (at != lengths_.end() && corrects_)
      out.push_back({paths_[static_cast<std::size_t>(at - lengths_.begin())].name(), value.value});
    else if (!value_of(out, value.channel) &&
             std::ranges::find(angles_, value.channel, &Channel::name) == angles_.end())
      out.push_back(value);
  }
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
