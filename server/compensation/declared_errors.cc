#include "server/compensation/declared_errors.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "server/core/units.h"

namespace driftwise::compensation {
namespace {

const BeamDescription* beam_of(const CellDescription& cell, const Channel& length) {
  if (!cell.correction) return nullptr;
  const auto found = std::ranges::find(cell.correction->beams, length, &BeamDescription::length);
  return found == cell.correction->beams.end() ? nullptr : &*found;
}

// The two axes beside this one, in cyclic order: y, z of x.
std::array<std::string, 2> others(const std::string& axis) {
  if (axis == "x") return {"y", "z"};
  if (axis == "y") return {"z", "x"};
  return {"x", "y"};
}

bool gives(const DeviceDescription& device, const std::string& symbol) {
  if (const auto* length = device.length(); length && length->channel.symbol == symbol) return true;
  return std::ranges::any_of(device.angles(),
                             [&](const auto& angle) { return angle.channel.symbol == symbol; });
}

// What measured the coordinate, as far as it is instruments of this cell; null: not stated.
const MeasuredBy* stated(const CellDescription& cell, const std::string& symbol,
                         const MeasuredCoordinates& measured_by) {
  const auto* found = find_measured_by(measured_by, symbol);
  if (found == nullptr) return nullptr;
  for (const auto& part : found->parts)
    for (const auto& id : part.devices) {
      const auto* device = cell.find_device(id);
      if (device == nullptr || !gives(*device, symbol)) return nullptr;
    }
  return found;
}

double declared_noise(const DeviceDescription& device, const std::string& symbol) {
  if (const auto* length = device.length(); length && length->channel.symbol == symbol)
    return length->u_length_nm;
  for (const auto& angle : device.angles())
    if (angle.channel.symbol == symbol) return angle.u_arcsec;
  return 0;
}

// Error of a constant of every reading of the coordinate: independent from instrument to
// instrument, each with its weight.
double constant_error(const CellDescription& cell, const MeasuredBy& coordinate) {
  double squares = 0;
  for (const auto& device : cell.devices)
    squares +=
        std::pow(coordinate.weight(device.id) * declared_noise(device, coordinate.symbol), 2);
  return std::sqrt(squares);
}

// The same of the coordinate's instruments; where it is not stated which measured the rows, the
// least of theirs.
double constant_error(const CellDescription& cell, const std::string& rotation,
                      const MeasuredCoordinates& measured_by) {
  const auto* coordinate = stated(cell, rotation, measured_by);
  return coordinate ? constant_error(cell, *coordinate) : reading_noise(cell, rotation, {});
}

void add_beam(const BeamDescription& beam, double weight, std::vector<DeclaredError>& out) {
  const std::string& axis = beam.length.symbol;
  const auto add = [&](UncertaintySource source, std::string by, double u, bool shared = true) {
    if (u > 0) out.push_back({source, axis, std::move(by), weight * u, shared});
  };
  for (const auto& other : others(axis)) {
    // Abbe: nm per arcsec of the tilt about an axis beside this one, for an offset along the other.
    add(UncertaintySource::beam_offset, "r" + other, nm_from_mm(beam.u_offset_mm) * kRadPerArcsec);
    // A beam that is not parallel to its axis sees a share of what happens along the others.
    add(UncertaintySource::beam_direction, other,
        nm_from_mm(rad_from_arcsec(beam.u_direction_arcsec)));
  }
  add(UncertaintySource::mirror, "1", beam.u_flatness_nm, false);
}

// A constant error of a tilt on the known lever arms, which move with the pose. With the path along
// x longer by ry a_z - rz a_y (correction.h), a reading of rz that is too large by e makes x too
// large by a_y e, and one of ry by -a_z e.
void add_tilts(const CellDescription& cell, const MeasuredCoordinates& measured_by,
               const BeamDescription& beam, std::vector<DeclaredError>& out) {
  const std::string& axis = beam.length.symbol;
  const auto [first, second] = others(axis);
  const auto add = [&](const std::string& about, const std::string& along, double sign) {
    const auto k = static_cast<std::size_t>(along[0] - 'x');
    const std::string rotation = "r" + about;
    const double rad = rad_from_arcsec(constant_error(cell, rotation, measured_by));
    for (const auto& [by, arm_mm] :
         {std::pair(std::string("1"), beam.offset_mm[k]), std::pair(along, beam.offset_per_mm[k])})
      if (rad > 0 && arm_mm != 0)
        out.push_back({UncertaintySource::tilts, axis, by, sign * nm_from_mm(arm_mm) * rad, true,
                       false, rotation});
  };
  add(first, second, -1);
  add(second, first, 1);
}

}  // namespace

std::vector<DeclaredError> declared_errors(const CellDescription& cell,
                                           const MeasuredCoordinates& measured_by) {
  std::vector<DeclaredError> out;
  for (const auto& device : cell.devices) {
    if (!device.length()) continue;
    const std::string& axis = device.length()->channel.symbol;
    const auto* coordinate = stated(cell, axis, measured_by);
    const double weight = coordinate ? coordinate->weight(device.id) : 1;
    if (weight == 0) continue;
    // The reading at the zero: every pose since has its error.
    if (device.length()->u_length_nm > 0)
      out.push_back(
          {UncertaintySource::laser, axis, "1", weight * device.length()->u_length_nm, true, true});
    if (device.length()->u_drift_nm_per_h != 0)
      out.push_back({UncertaintySource::drift, axis, "h",
                     weight * device.length()->u_drift_nm_per_h, true, false, "h"});
    if (device.length()->u_drift_nm_per_k != 0) {
      const std::string& room = device.length()->drift_channel.symbol;
      out.push_back({UncertaintySource::drift, axis, room,
                     weight * device.length()->u_drift_nm_per_k, true, false, room});
    }
    if (const auto* beam = beam_of(cell, device.length()->channel)) add_beam(*beam, weight, out);
  }
  if (cell.correction)
    for (const auto& beam : cell.correction->beams)
      if (std::ranges::any_of(cell.devices, [&beam](const auto& device) {
            return device.length() && device.length()->channel == beam.length;
          }))
        add_tilts(cell, measured_by, beam, out);
  // A rotation that the pose has as a coordinate: the reading at the zero, as of a length.
  for (const char* rotation : {"rx", "ry", "rz"}) {
    const double u = constant_error(cell, rotation, measured_by);
    if (u > 0) out.push_back({UncertaintySource::tilts, rotation, "1", u, true, true, rotation});
  }
  if (cell.load && cell.load->u_n > 0)
    out.push_back({UncertaintySource::force, "force", "1", cell.load->u_n, false});
  return out;
}

double reading_noise(const CellDescription& cell, const std::string& symbol,
                     const MeasuredCoordinates& measured_by) {
  if (const auto* coordinate = stated(cell, symbol, measured_by)) {
    double rows = 0, squares = 0;
    for (const auto& part : coordinate->parts) {
      double of_sum = 0;
      for (const auto& id : part.devices)
        of_sum += std::pow(declared_noise(*cell.find_device(id), symbol), 2);
      rows += part.rows;
      squares += part.rows * of_sum / std::pow(static_cast<double>(part.devices.size()), 2);
    }
    return std::sqrt(squares / rows);
  }
  std::optional<double> least;
  const auto see = [&](const Channel& channel, double u) {
    if (channel.symbol == symbol) least = std::min(u, least.value_or(u));
  };
  for (const auto& device : cell.devices) {
    if (const auto* length = device.length()) see(length->channel, length->u_length_nm);
    for (const auto& angle : device.angles()) see(angle.channel, angle.u_arcsec);
    for (const auto& axis : device.axes()) see(axis.channel, axis.u_scale_nm);
  }
  return least.value_or(0);
}

}  // namespace driftwise::compensation
