#include "drivers/load_actuator/weights.h"

#include "server/core/try.h"

namespace driftwise::load_actuator {
Weights::Weights(DeviceDescription device, const transport::Address& address,
                 asio::any_io_executor executor, Clock& clock, SharedByAddress* shared)
    : LineDevice(std::move(device), address, std::move(executor), clock,
                 {.resync_request = "IDN?\n", .answers_each_connection = true}, shared) {}

Awaitable<Result<void>> Weights::set_up() {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("IDN?"));
  const auto identity = parse_identity(reply);
  if (!identity) co_return wrong(identity);
  know_identity(*identity, reply);
  co_return Result<void>{};
}

Awaitable<Result<LoadState>> Weights::state() {
  DRIFTWISE_CO_TRY(const auto turn, co_await take_turn());
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("LOAD?"));
  const auto load = parse_load(reply);
  if (!load) co_return wrong(load);
  co_return LoadState{clock_.now().utc, load->force_n, load->resting};
}

Awaitable<Result<void>> Weights::set_force(double force_n) {
  DRIFTWISE_CO_TRY(const auto turn, co_await take_turn());
  DRIFTWISE_CO_TRY(const auto reply, co_await ask(load_command(force_n)));
  const auto accepted = parse_ok(reply);
  if (!accepted) co_return wrong(accepted);
  co_return Result<void>{};
}

}  // namespace driftwise::load_actuator
