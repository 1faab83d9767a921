#pragma once
// Arguments of a device kind's factory, and the device that it makes.

#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>

#include "server/core/ports/clock.h"
#include "server/core/ports/control/shared_by_address.h"
#include "server/core/ports/instrument.h"
#include "server/core/ports/load_actuator.h"
#include "server/core/ports/motion_controller.h"
#include "server/core/ports/stabiliser.h"

namespace driftwise {

namespace locks {
class Claims;
}

struct DeviceContext {
  asio::any_io_executor executor;
  Clock& clock;  // outlives the device
  // The machines that this process drives; none: a check, or nobody else can drive them.
  std::shared_ptr<locks::Claims> claims = {};
  // Of the devices that are made together; none: each has a connection of its own.
  std::shared_ptr<SharedByAddress> shared = {};
};

// A device behind the port of its role: motion, stabiliser and load have their own, everything that
// is only read is an Instrument.
struct MadeDevice {
  using Port = std::variant<std::unique_ptr<Instrument>, std::unique_ptr<MotionController>,
                            std::unique_ptr<Stabiliser>, std::unique_ptr<LoadActuator>>;
  Port port;

  MadeDevice() = default;  // none yet, for Result
  template <class Made>
  requires std::is_constructible_v<Port, std::unique_ptr<Made>> MadeDevice(
      std::unique_ptr<Made> made)
      : port(std::move(made)) {}

  Device& device() const {
    return std::visit([](const auto& one) -> Device& { return *one; }, port);
  }
  // nullptr: behind another port.
  template <class As>
  As* as() const {
    const auto* found = std::get_if<std::unique_ptr<As>>(&port);
    return found ? found->get() : nullptr;
  }
};

}  // namespace driftwise
