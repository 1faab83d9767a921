#include "drivers/load_actuator/weights.h"

#include "server/core/try.h"

namespace driftwise::load_actuator {
namespace {

transport::LinkSettings settings_of(const DeviceDescription& device,
                                    const std::string& identity_line) {
  transport::LinkSettings out;
  out.device = device.id;
  out.address = device.address;
  out.resync_request = "IDN?\n";
  out.is_resync_reply = [&identity_line](std::string_view reply) {
    return !identity_line.empty() && reply == identity_line;
  };
  return out;
}

}  // namespace

Weights::Weights(DeviceDescription device, const transport::Address& address,
                 asio::any_io_executor executor, Clock& clock)
    : device_(std::move(device)),
      clock_(clock),
      timeout_(nanoseconds_from_s(device_.timeout_s)),
      link_(executor, clock, settings_of(device_, identity_line_),
            transport::make_stream(executor, address, {})),
      turn_(executor) {}

template <class T>
tl::unexpected<Error> Weights::wrong(const Result<T>& parsed) {
  if (parsed.error().reason == "BAD_REPLY") link_.lose_step();
  return link_.wrong_reply(parsed.error());
}

Awaitable<Result<void>> Weights::prepare() {
  const auto turn = co_await turn_.take();
  co_return co_await get_ready();
}

Awaitable<Result<void>> Weights::get_ready() {
  if (auto up = co_await link_.connect(timeout_); !up) co_return up;
  if (link_.generation() == set_up_generation_) co_return Result<void>{};
  identity_line_.clear();
  DRIFTWISE_CO_TRY(const auto reply, co_await link_.ask("IDN?\n", timeout_));
  const auto identity = parse_identity(reply);
  if (!identity) {
    const Error error = wrong(identity).value();
    link_.drop(error.message);
    co_return tl::unexpected(error);
  }
  identity_line_ = transport::without_line_ends(reply);
  link_.set_identity(*identity);
  set_up_generation_ = link_.generation();
  co_return Result<void>{};
}

Awaitable<Result<LoadState>> Weights::state() {
  const auto turn = co_await turn_.take();
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await get_ready());
  DRIFTWISE_CO_TRY(const auto reply, co_await link_.ask("LOAD?\n", timeout_));
  const auto load = parse_load(reply);
  if (!load) co_return wrong(load);
  co_return LoadState{clock_.now().utc, load->force_n, load->resting};
}

Awaitable<Result<void>> Weights::set_force(double force_n) {
  const auto turn = co_await turn_.take();
  if (auto ready = co_await get_ready(); !ready) co_return ready;
  auto command = load_command(force_n) + "\n";
  DRIFTWISE_CO_TRY(const auto reply, co_await link_.ask(std::move(command), timeout_));
  const auto accepted = parse_ok(reply);
  if (!accepted) co_return wrong(accepted);
  co_return Result<void>{};
}

}  // namespace driftwise::load_actuator
