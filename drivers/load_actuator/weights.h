#pragma once
// The loop behind LoadActuator. Use make_load_actuator.

#include "drivers/load_actuator/load_codec.h"
#include "drivers/transport/line_device.h"
#include "server/core/ports/load_actuator.h"

namespace driftwise::load_actuator {

class Weights final : public transport::LineDevice<LoadActuator> {
 public:
  Weights(DeviceDescription device, const transport::Address& address,
          asio::any_io_executor executor, Clock& clock, SharedByAddress* shared = nullptr);

  Awaitable<Result<LoadState>> state() override;
  Awaitable<Result<void>> set_force(double force_n) override;

 private:
  Awaitable<Result<void>> set_up() override;
};

}  // namespace driftwise::load_actuator
