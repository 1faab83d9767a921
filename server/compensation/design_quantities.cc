#include "server/compensation/design_quantities.h"

#include <algorithm>

#include "server/effects/term_order.h"

namespace driftwise::compensation {
namespace {

using Set = std::function<void(CellDescription&, double)>;

class Quantities {
 public:
  void instrument(const std::string& subject, const char* key, double value, const char* what,
                  Set set, double low = 0) {
    add({subject, key, DesignKind::instrument, value, low, 1e9, what, std::move(set)});
  }
  void factor(const std::string& subject, const char* key, DesignKind kind, const char* what) {
    add({subject, key, kind, 1, 0, 1e3, what, {}});
  }
  std::vector<DesignQuantity> take() { return std::move(all_); }

 private:
  void add(DesignQuantity quantity) { all_.push_back(std::move(quantity)); }
  std::vector<DesignQuantity> all_;
};

void add_device(const DeviceDescription& device, std::size_t index, Quantities& out) {
  for (std::size_t i = 0; i < device.axes().size(); ++i)
    out.instrument(device.axes()[i].channel.symbol, "u_scale_nm", device.axes()[i].u_scale_nm,
                   "reading of the motor's scale", [index, i](CellDescription& cell, double value) {
                     cell.devices[index].become<MotionSettings>().axes[i].u_scale_nm = value;
                   });
  if (const auto* length = device.length()) {
    out.instrument(length->channel.symbol, "u_length_nm", length->u_length_nm,
                   "noise of one length reading", [index](CellDescription& cell, double value) {
                     cell.devices[index].become<LengthSettings>().u_length_nm = value;
                   });
    out.instrument(
        length->channel.symbol, "u_drift_nm_per_h", length->u_drift_nm_per_h,
        "drift of the length since the zero",
        [index](CellDescription& cell, double value) {
          cell.devices[index].become<LengthSettings>().u_drift_nm_per_h = value;
        },
        -1e9);
    if (!length->drift_channel.symbol.empty())
      out.instrument(
          length->channel.symbol, "u_drift_nm_per_k", length->u_drift_nm_per_k,
          "drift of the length with its thermometer since the zero",
          [index](CellDescription& cell, double value) {
            cell.devices[index].become<LengthSettings>().u_drift_nm_per_k = value;
          },
          -1e9);
  }
  for (std::size_t i = 0; i < device.angles().size(); ++i)
    out.instrument(device.angles()[i].channel.symbol, "u_arcsec", device.angles()[i].u_arcsec,
                   "constant error of a rotation", [index, i](CellDescription& cell, double value) {
                     cell.devices[index].become<AngleSettings>().angles[i].u_arcsec = value;
                   });
  for (std::size_t i = 0; i < device.probes().size(); ++i)
    out.instrument(device.probes()[i].channel.symbol, "u_k", device.probes()[i].u_k,
                   "certificate of a thermometer", [index, i](CellDescription& cell, double value) {
                     cell.devices[index].become<TemperatureSettings>().probes[i].u_k = value;
                   });
}

void add_beam(const BeamDescription& beam, std::size_t i, Quantities& out) {
  const std::string& subject = beam.length.symbol;
  const auto set = [i](auto member) {
    return Set([i, member](CellDescription& cell, double value) {
      cell.correction->beams[i].*member = value;
    });
  };
  out.instrument(subject, "u_offset_mm", beam.u_offset_mm, "how well its lever arm is known",
                 set(&BeamDescription::u_offset_mm));
  out.instrument(subject, "u_direction_arcsec", beam.u_direction_arcsec, "squareness of the beam",
                 set(&BeamDescription::u_direction_arcsec));
  out.instrument(subject, "u_flatness_nm", beam.u_flatness_nm, "flatness of its mirror",
                 set(&BeamDescription::u_flatness_nm));
  static constexpr const char* kOffsets[] = {"offset_x_mm", "offset_y_mm", "offset_z_mm"};
  for (std::size_t axis = 0; axis < 3; ++axis)
    out.instrument(
        subject, kOffsets[axis], beam.offset_mm[axis], "its lever arm",
        [i, axis](CellDescription& cell, double value) {
          cell.correction->beams[i].offset_mm[axis] = value;
        },
        -1e9);
}

}  // namespace

std::vector<DesignQuantity> design_quantities(const calibration::Model& model,
                                              const CellDescription& cell) {
  Quantities out;
  for (std::size_t i = 0; i < cell.devices.size(); ++i) add_device(cell.devices[i], i, out);
  if (cell.correction)
    for (std::size_t i = 0; i < cell.correction->beams.size(); ++i)
      add_beam(cell.correction->beams[i], i, out);
  if (cell.load)
    out.instrument("force", "u_n", cell.load->u_n, "what hangs",
                   [](CellDescription& changed, double value) { changed.load->u_n = value; });
  std::vector<std::string> thermometers;
  for (const auto& output : model.outputs)
    for (const auto& term : output.terms)
      for (const auto& symbol : effects::symbols_of(term)) {
        const auto range = std::ranges::find(model.domain, symbol,
                                             [](const auto& one) { return one.channel.symbol; });
        if (range == model.domain.end() || !is_structure_temperature(range->channel) ||
            std::ranges::find(thermometers, symbol) != thermometers.end())
          continue;
        thermometers.push_back(symbol);
      }
  std::ranges::sort(thermometers);
  for (const auto& symbol : thermometers)
    out.factor(symbol, "expansion", DesignKind::expansion,
               "what the robot does with it, times today's: 0.1 of steel is Invar");
  for (const auto source :
       {UncertaintySource::fit, UncertaintySource::residual, UncertaintySource::drift})
    out.factor(std::string(to_string(source)), "factor", DesignKind::line,
               "the line as a whole, times today's");
  return out.take();
}

}  // namespace driftwise::compensation
