#pragma once
// The loop behind Stabiliser: hops to the Modbus thread and back. Use make_watlow_ez_zone.

#include <atomic>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>

#include "drivers/transport/back_off.h"
#include "drivers/watlow_ez_zone/temperature_controller.h"
#include "server/core/ports/clock.h"
#include "server/core/ports/control/tunable_loop.h"
#include "server/core/ports/stabiliser.h"

namespace driftwise::watlow {

class PeltierStabiliser final : public Stabiliser, public TunableLoop {
 public:
  PeltierStabiliser(DeviceDescription device, Options options, transport::Address address,
                    std::shared_ptr<ModbusLine> line, asio::any_io_executor executor, Clock& clock);
  ~PeltierStabiliser() override;

  const DeviceDescription& description() const override { return device_; }
  DeviceHealth health() const override { return health_; }
  std::vector<std::string> recent_exchanges() const override { return recent_; }
  Awaitable<Result<void>> prepare() override;
  void close() override;
  Awaitable<Result<Reading>> read() override;
  Awaitable<Result<void>> set_point(double degc) override;
  LoopTuning declared_tuning() const override { return declared_; }
  Awaitable<Result<LoopTuning>> tuning() override;
  Awaitable<Result<LoopTuning>> set_tuning(LoopTuning wanted) override;

 private:
  // Runs job(controller, timeout) on the line's thread; keeps health and back-off.
  template <class Job>
  auto run(Job job) -> Awaitable<decltype(job(std::declval<TemperatureController&>(),
                                              std::chrono::nanoseconds()))>;
  Awaitable<Result<void>> wait_out_back_off(std::chrono::nanoseconds limit);
  struct LineReport {  // gathered on the Modbus thread, after the job
    ModbusMaster::Figures figures;
    std::vector<std::string> recent;
    bool connected = false;
  };
  void note(const Error* error, LineReport report);
  void disconnect_soon();

  DeviceDescription device_;
  LoopTuning declared_;
  Clock& clock_;
  std::string symbol_;
  asio::steady_timer pause_;
  transport::BackOff back_off_;
  std::chrono::steady_clock::time_point not_before_{};
  TemperatureController controller_;  // touched on the line's thread only
  DeviceHealth health_;               // of the last finished job: the executor's thread only
  std::vector<std::string> recent_;
  std::int64_t connections_ = 0, sequence_ = 0;
  bool closed_ = false;  // by its owner, while a job may still run
  // Jobs that the line's thread has not ended yet. Its own: the last step of a job comes after the
  // destructor that waited for it.
  std::shared_ptr<std::atomic<int>> jobs_ = std::make_shared<std::atomic<int>>(0);
  std::shared_ptr<ModbusLine> line_;
};

}  // namespace driftwise::watlow
