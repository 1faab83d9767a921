#include "drivers/watlow_ez_zone/peltier_stabiliser.h"

#include <boost/asio/co_spawn.hpp>

#include "drivers/transport/link.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::watlow {
namespace {

template <class Job>
auto as_coroutine(Job job) -> Awaitable<decltype(job())> {
  co_return job();
}

}  // namespace

PeltierStabiliser::PeltierStabiliser(DeviceDescription device, Options options,
                                     transport::Address address, std::shared_ptr<ModbusLine> line,
                                     asio::any_io_executor executor, Clock& clock)
    : device_(std::move(device)),
      declared_(options.declared),
      clock_(clock),
      symbol_(symbol_from_id(device_.id)),
      pause_(executor),
      back_off_(transport::seed_from(device_.id + device_.address), {}),
      controller_({device_.id, device_.address, std::move(address), line, options.unit_id},
                  options),
      line_(std::move(line)) {}

PeltierStabiliser::~PeltierStabiliser() {
  disconnect_soon();
  for (int left = jobs_->load(); left > 0; left = jobs_->load()) jobs_->wait(left);
}

// On the line's own thread, behind the job that may be under way.
void PeltierStabiliser::disconnect_soon() {
  ++*jobs_;
  asio::post(line_->thread, [this, jobs = jobs_] {
    controller_.line().disconnect();
    --*jobs;
    jobs->notify_all();
  });
}

Awaitable<Result<void>> PeltierStabiliser::wait_out_back_off(std::chrono::nanoseconds limit) {
  const auto wait = not_before_ - std::chrono::steady_clock::now();
  if (wait <= wait.zero()) co_return Result<void>{};
  pause_.expires_after(std::min<std::chrono::steady_clock::duration>(wait, limit));
  (void)co_await pause_.async_wait(asio::as_tuple(asio::use_awaitable));
  if (wait <= limit) co_return Result<void>{};
  co_return fail(
      ErrorCode::unavailable, reasons::kLinkDown,
      "device '" + device_.id + "' at " + device_.address +
          ": not connected, waiting before the next attempt; last error: " + health_.last_error);
}

template <class Job>
auto PeltierStabiliser::run(Job job)
    -> Awaitable<decltype(job(std::declval<TemperatureController&>(),
                              std::chrono::nanoseconds()))> {
  const auto timeout =
      clock_.wall_from(nanoseconds_from_s(device_.timeout_s), transport::kShortestTimeout);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await wait_out_back_off(timeout));
  closed_ = false;
  if (health_.link != LinkState::connected) health_.link = LinkState::connecting;
  ++*jobs_;
  auto work = [this, job, timeout, jobs = jobs_] {
    auto result = job(controller_, timeout);
    ModbusMaster& line = controller_.line();
    std::pair out(std::move(result),
                  LineReport{line.figures(), line.log().lines(), line.connected()});
    --*jobs;
    jobs->notify_all();
    return out;
  };
  auto [result, report] = co_await asio::co_spawn(
      line_->thread.get_executor(), as_coroutine(std::move(work)), asio::use_awaitable);
  note(result ? nullptr : &result.error(), std::move(report));
  co_return std::move(result);
}

void PeltierStabiliser::note(const Error* error, LineReport report) {
  health_.exchanges = report.figures.exchanges;
  health_.errors = report.figures.errors;
  health_.last_latency_s = report.figures.last_latency_s;
  recent_ = std::move(report.recent);
  if (error == nullptr) {
    if (health_.link != LinkState::connected) {
      if (connections_++ > 0) ++health_.reconnects;
      health_.last_error.clear();
    }
    health_.identity = "Watlow EZ-ZONE PM register map";
    health_.last_good = clock_.now().utc;
    back_off_.after_success();
  } else {
    health_.last_error = error->message;
    if (!report.connected)
      not_before_ = std::chrono::steady_clock::now() + back_off_.after_failure();
  }
  health_.link = closed_            ? LinkState::disconnected
                 : report.connected ? LinkState::connected
                                    : LinkState::failed;
}

Awaitable<Result<void>> PeltierStabiliser::prepare() {
  co_return co_await run(
      [](TemperatureController& controller, auto timeout) { return controller.prepare(timeout); });
}

Awaitable<Result<void>> PeltierStabiliser::set_point(double degc) {
  co_return co_await run([degc](TemperatureController& controller, auto timeout) {
    return controller.set_point(degc, timeout);
  });
}

Awaitable<Result<LoopTuning>> PeltierStabiliser::tuning() {
  co_return co_await run(
      [](TemperatureController& controller, auto timeout) { return controller.tuning(timeout); });
}

Awaitable<Result<LoopTuning>> PeltierStabiliser::set_tuning(LoopTuning wanted) {
  co_return co_await run([wanted](TemperatureController& controller, auto timeout) {
    return controller.set_tuning(wanted, timeout);
  });
}

Awaitable<Result<Reading>> PeltierStabiliser::read() {
  const CellTime asked = clock_.now().utc;
  DRIFTWISE_CO_TRY(const auto state,
                   co_await run([](TemperatureController& controller, auto timeout) {
                     return controller.read(timeout);
                   }));
  Reading out;
  out.device = device_.id;
  out.start = asked;
  out.end = clock_.now().utc;
  out.sequence = ++sequence_;
  out.values.push_back({symbol_ + "_degC", state.process_degc});
  out.values.push_back({symbol_ + "_set_degC", state.set_point_degc});
  out.values.push_back({symbol_ + "_power_pct", state.power_pct});
  co_return out;
}

void PeltierStabiliser::close() {
  closed_ = true;
  pause_.cancel();
  health_.link = LinkState::disconnected;
  disconnect_soon();
}

}  // namespace driftwise::watlow
