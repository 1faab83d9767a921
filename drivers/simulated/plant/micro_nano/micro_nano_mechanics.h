#pragma once
// Where the Micro-Nano's platform is: made geometry, warmed up, pulled.
//
// Base frame: z up, x along arm 1 (azimuth 0), origin where the middle of the platform's joints is
// with all scales at 0 in the nominal geometry at the reference temperature. Nothing is linearised:
// the bars' loop is closed with the joints where guides and temperatures put them; then every bar
// is as much longer as its flexures give under the force it carries, and the loop is closed again.

#include "drivers/simulated/plant/micro_nano/micro_nano_machine.h"
#include "drivers/simulated/plant/thermal/thermal_network.h"

namespace driftwise::simulated {

// The loop with stiff bars.
struct Assembly {
  std::array<Bar, kBars> bars{};
  std::array<Vec3, kBars> swing_rad{};  // of each bar from its neutral direction
  PlatformPose stiff;
};

// The same platform under its weight, the flexures' own moments and a pull at `attach` (base frame,
// z up): every bar gives under what it carries, and the loop is closed again. tangents: along each
// arm's joint line.
PlatformPose rested(const Assembly& assembly, const DeltaParameters& delta,
                    const PerArm<Vec3>& tangents, Vec3 attach_mm, Vec3 pull_n);

class MicroNanoMechanics {
 public:
  MicroNanoMechanics(const MicroNanoParameters& parameters, const Machine& machine);

  // stage_mm are the stages' true positions on their guides.
  Assembly assembly(const PerArm<double>& stage_mm, const NodeTemperatures& degc) const;

  // The same under gravity, the flexures' own moments and the wire's pull at `attach` (base frame).
  PlatformPose pulled(const Assembly& assembly, Vec3 attach_mm, Vec3 pull_n) const;

  // A point of the platform's frame that moves with its material.
  Vec3 on_platform(const PlatformPose& pose, Vec3 point_mm, const NodeTemperatures& degc) const;

  double stage_from_scale_mm(std::size_t axis, double scale_mm, const NodeTemperatures& degc) const;

 private:
  Vec3 swing_rad(std::size_t k, const Assembly& assembly) const;
  Bar bar(std::size_t k, double stage_mm, const NodeTemperatures& degc) const;
  double warm_k(int part, const NodeTemperatures& degc) const;

  const MicroNanoParameters& parameters_;
  const Machine& machine_;
  double drop_mm_;  // carriage's joints above the platform's, nominal
};

// Way by which a guide's leg that leans by x draws its end in, mm.
double drawn_in_mm(double leg_mm, double factor, double x_mm);

// What a length that follows temperatures has grown by since the reference, mm.
double growth_mm(const WarmLength& length, double reference_degc, const NodeTemperatures& degc);
double growth_mm(const std::vector<WarmLength>& lengths, double reference_degc,
                 const NodeTemperatures& degc);

}  // namespace driftwise::simulated
