#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <utility>

#include "server/application/ports/host.h"
#include "server/application/serving/targets.h"
#include "server/rpc/shared/watch_sources.h"
#include "server/rpc/target/convert_target.h"

namespace driftwise::rpc {
namespace {

using application::Host;
using application::Targets;
using WallClock = std::chrono::steady_clock;

// An answer, made on whichever thread.
struct Answered {
  v1::WatchTargetsResponse response;
  Result<void> result;
};

std::shared_ptr<Answered> answered_by(const compensation::Snapshot& snapshot,
                                      const compensation::TargetRequest& request) {
  auto answered = std::make_shared<Answered>();
  answered->result = answer_target(snapshot, request, false, *answered->response.mutable_target());
  return answered;
}

// An arm's joints are searched for on the background thread, once at a time for each watch.
class TargetSource final : public StreamSource<v1::WatchTargetsResponse> {
 public:
  TargetSource(const Host& host, Targets& targets, compensation::TargetRequest request,
               Nanoseconds min_interval, std::function<std::shared_ptr<void>()> take_place)
      : host_(host),
        targets_(targets),
        request_(request),
        min_interval_(min_interval),
        take_place_(std::move(take_place)),
        timer_(host.executor()) {}

  void start(std::function<void()> wake) override {
    wake_ = wake;
    watch_ = targets_.watch_snapshots([this, wake = std::move(wake)] {
      due_ = true;
      wake();
    });
  }

  std::optional<v1::WatchTargetsResponse> next() override {
    if (found_) return told(std::exchange(found_, nullptr));
    if (!due_ || end_ || searching_) return std::nullopt;
    const auto now = WallClock::now();
    if (now < not_before_) {
      wait_until(not_before_);
      return std::nullopt;
    }
    due_ = false;
    not_before_ = now + min_interval_;
    const auto snapshot = targets_.snapshots().read();
    request_.now = host_.now();
    static const compensation::Snapshot nothing;  // its refusal says that no model serves
    const auto& present = snapshot ? *snapshot : nothing;
    if (!compensation::needs_search(present, request_)) return told(answered_by(present, request_));
    if (auto place = take_place_()) {
      search(present, std::move(place));
    } else {
      due_ = true;
      not_before_ = now + std::max<Nanoseconds>(min_interval_, std::chrono::seconds(1));
      wait_until(not_before_);
    }
    return std::nullopt;
  }
  std::optional<Result<void>> ended() override { return end_; }

 private:
  std::optional<v1::WatchTargetsResponse> told(const std::shared_ptr<Answered>& answered) {
    if (answered->result) return std::move(answered->response);
    end_ = answered->result;
    return std::nullopt;
  }

  // From a copy: whoever holds the board's snapshot holds up the writer.
  void search(const compensation::Snapshot& present, std::shared_ptr<void> place) {
    searching_ = true;
    boost::asio::post(host_.background(),
                      [kept = std::make_shared<const compensation::Snapshot>(present),
                       request = request_, executor = host_.executor(),
                       me = std::weak_ptr<TargetSource*>(me_), place = std::move(place)]() mutable {
                        boost::asio::post(
                            executor, [found = answered_by(*kept, request), me = std::move(me)] {
                              const auto alive = me.lock();  // a source goes on this thread
                              if (alive) (*alive)->take(found);
                            });
                      });
  }
  void take(std::shared_ptr<Answered> found) {
    searching_ = false;
    found_ = std::move(found);
    wake_();
  }

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
  std::function<std::shared_ptr<void>()> take_place_;
  boost::asio::steady_timer timer_;
  WallClock::time_point not_before_{};
  std::function<void()> wake_;
  bool due_ = true;  // the first target goes out at once
  bool searching_ = false;
  std::shared_ptr<Answered> found_;  // by a search, not told yet
  const std::shared_ptr<TargetSource*> me_ = std::make_shared<TargetSource*>(this);
  std::optional<Result<void>> end_;
  std::shared_ptr<void> watch_;  // last: it goes first, and with it the callback that knows this
};

}  // namespace

std::unique_ptr<StreamSource<v1::WatchTargetsResponse>> watch_targets(
    const Host& host, Targets& targets, compensation::TargetRequest request,
    Nanoseconds min_interval, std::function<std::shared_ptr<void>()> take_place) {
  return std::make_unique<TargetSource>(host, targets, request, min_interval,
                                        std::move(take_place));
}

}  // namespace driftwise::rpc
