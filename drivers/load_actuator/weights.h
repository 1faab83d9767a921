#pragma once
// The loop behind LoadActuator. Use make_load_actuator.

#include "drivers/load_actuator/load_codec.h"
#include "drivers/transport/link.h"
#include "drivers/transport/turn.h"
#include "server/core/ports/load_actuator.h"

namespace driftwise::load_actuator {

class Weights final : public LoadActuator {
 public:
  Weights(DeviceDescription device, const transport::Address& address,
          asio::any_io_executor executor, Clock& clock);

  const DeviceDescription& description() const override { return device_; }
  DeviceHealth health() const override { return link_.health(); }
  std::vector<std::string> recent_exchanges() const override { return link_.log().lines(); }
  Awaitable<Result<void>> prepare() override;
  void close() override { link_.close(); }
  Awaitable<Result<LoadState>> state() override;
  Awaitable<Result<void>> set_force(double force_n) override;

 private:
  Awaitable<Result<void>> get_ready();
  template <class T>
  tl::unexpected<Error> wrong(const Result<T>& parsed);

  DeviceDescription device_;
  Clock& clock_;
  Nanoseconds timeout_;
  std::string identity_line_;  // brings the line back in step
  transport::Link link_;
  transport::Turn turn_;
  std::int64_t set_up_generation_ = 0;
};

}  // namespace driftwise::load_actuator
