#pragma once
// The laser interferometer's electronics: light path in, length out.
//
// It counts the optical path n (dead path + x), divides by the index it believes in (its own air
// probe, pressure and humidity as typed in at set-up) and takes off what the typed-in dead path has
// changed by since the zero.

#include <cstdint>

#include "drivers/simulated/plant/cell/slow_world.h"
#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

class Interferometer {
 public:
  // typed_in: pressure and humidity at set-up, rounded as a person types them.
  // beam: which of the frame's beams is this one's.
  Interferometer(const InterferometerParameters& parameters, const Weather& typed_in,
                 std::size_t beam);

  // What the electronics shows, nm since its zero, for a true distance of dead path + true_nm; no
  // noise of reading.
  double shown_nm(double true_nm, const Frame& frame) const;
  // The next readings are relative to the value shown now; offset_nm: the noise of the instant.
  void zero(double true_nm, const Frame& frame, double offset_nm);
  void set_dead_path_mm(double mm) { typed_dead_path_mm_ = mm; }

 private:
  double index(const Frame& frame) const;
  double believed_index(const Frame& frame) const;
  double path_mm(double true_nm) const;
  double raw_nm(double true_nm, const Frame& frame) const;

  InterferometerParameters parameters_;
  std::size_t beam_;
  Weather typed_in_;
  double typed_dead_path_mm_;
  double path_at_zero_mm_ = 0, believed_at_zero_ = 1, zero_nm_ = 0;
};

}  // namespace driftwise::simulated
