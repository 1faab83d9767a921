// The list of devices, one line each: the folder's name. CMake reads it too. Each folder's
// device.cc defines `const DeviceKind device_kind::<folder>`.

#include "drivers/all_devices.h"

#include <array>

// clang-format off
#define DRIFTWISE_DEVICES(DEVICE) \
  DEVICE(pi_gcs)                  \
  DEVICE(keithley_2701)           \
  DEVICE(interferometer_adapter)  \
  DEVICE(lds1000)                 \
  DEVICE(watlow_ez_zone)          \
  DEVICE(load_actuator)           \
  DEVICE(inclinometer)            \
  DEVICE(touch_probe)             \
  DEVICE(nut_ups)                 \
  // end of the list
// clang-format on

namespace driftwise {

#define DECLARED(folder) extern const DeviceKind folder;
namespace device_kind {
DRIFTWISE_DEVICES(DECLARED)
}
#undef DECLARED

#define LISTED(folder) &device_kind::folder,
DeviceKinds drivers::all_devices() {
  static constexpr std::array kAll{DRIFTWISE_DEVICES(LISTED)};
  return kAll;
}
#undef LISTED

}  // namespace driftwise
