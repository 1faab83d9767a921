#include <boost/asio/steady_timer.hpp>
#include <chrono>

#include "server/application/ports/host.h"
#include "server/application/serving/targets.h"
#include "server/rpc/shared/watch_sources.h"
#include "server/rpc/target/convert_target.h"

namespace driftwise::rpc {
namespace {

using application::Host;
using application::Targets;
using WallClock = std::chrono::steady_clock;

class TargetSource final : public StreamSource<v1::WatchTargetsResponse> {
 public:
  TargetSource(const Host& host, Targets& targets, compensation::TargetRequest request,
               Nanoseconds min_interval)
      : host_(host),
        targets_(targets),
        request_(request),
        min_interval_(min_interval),
        timer_(host.executor()) {}

  void start(std::function<void()> wake) override {
    wake_ = wake;
    watch_ = targets_.watch_snapshots([this, wake = std::move(wake)] {
      due_ = true;
      wake();
    });
  }

  std::optional<v1::WatchTargetsResponse> next() override {
    if (!due_ || end_) return std::nullopt;
    const auto now = WallClock::now();
    if (now < not_before_) {
      wait_until(not_before_);
      return std::nullopt;
    }
    due_ = false;
    not_before_ = now + min_interval_;
    v1::WatchTargetsResponse response;
    const auto snapshot = targets_.snapshots().read();
    request_.now = host_.now();
    const compensation::Snapshot nothing;  // its refusal says that no model serves
    const auto answered =
        answer_target(snapshot ? *snapshot : nothing, request_, false, *response.mutable_target());
    if (!answered) {
      end_ = answered;
      return std::nullopt;
    }
    return response;
  }
  std::optional<Result<void>> ended() override { return end_; }

 private:
  void wait_until(WallClock::time_point instant) {
    timer_.expires_at(instant);
    timer_.async_wait([wake = wake_](boost::system::error_code cancelled) {
      if (!cancelled) wake();
    });
  }

  const Host& host_;
  Targets& targets_;
  compensation::TargetRequest request_;
  Nanoseconds min_interval_;
  boost::asio::steady_timer timer_;
  WallClock::time_point not_before_{};
  std::function<void()> wake_;
  bool due_ = true;  // the first target goes out at once
  std::optional<Result<void>> end_;
  std::shared_ptr<void> watch_;  // last: it goes first, and with it the callback that knows this
};

}  // namespace

std::unique_ptr<StreamSource<v1::WatchTargetsResponse>> watch_targets(
    const Host& host, Targets& targets, compensation::TargetRequest request,
    Nanoseconds min_interval) {
  return std::make_unique<TargetSource>(host, targets, request, min_interval);
}

}  // namespace driftwise::rpc
