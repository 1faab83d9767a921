#include "server/watchdog/watchdog.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <deque>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/watchdog/heads_log.h"
#include "server/watchdog/watch_book.h"
#include "server/watchdog/watchdog_door.h"

namespace driftwise::watchdog {
namespace {

constexpr double kLongestRetry_s = 60;

UtcTime utc_now() {
  return {std::chrono::duration_cast<std::chrono::nanoseconds>(
              std::chrono::system_clock::now().time_since_epoch())
              .count()};
}

double monotonic_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Messages on their way: one at a time, in order, on a thread of their own, so that a slow receiver
// never makes a cell look silent.
class Outbox {
 public:
  Outbox(boost::asio::io_context& context, const ReceiverDescription& receiver, Notifier& notifier,
         const std::function<void(const std::string&)>& say)
      : context_(context), receiver_(receiver), notifier_(notifier), say_(say) {}
  ~Outbox() {
    notifier_.shut_down();
    thread_.join();
  }
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  void add(std::vector<AlarmNews> news) {
    for (auto& one : news) {
      say_(std::string(one.kind == NewsKind::resolved ? "over: " : "") + one.alarm.message);
      waiting_.push_back(std::move(one));
    }
  }

  void look() {
    repeat_what_stands();
    if (waiting_.empty() || under_way_ || monotonic_s() < next_try_s_) return;
    under_way_ = true;
    Notice notice{waiting_.front().alarm.subject, "", utc_now(), {waiting_.front()}, false};
    boost::asio::post(thread_, [this, notice = std::move(notice)] {
      auto said = notifier_.tell(receiver_, notice);
      boost::asio::post(context_, [this, said = std::move(said)] { told(said); });
    });
  }

 private:
  void told(const Result<std::string>& said) {
    under_way_ = false;
    if (!said) {
      retry_s_ = std::clamp(2 * retry_s_, 1.0, kLongestRetry_s);
      next_try_s_ = monotonic_s() + retry_s_;
      say_("not delivered, tried again: " + said.error().message);
      return;
    }
    say_("delivered: " + *said);
    retry_s_ = next_try_s_ = 0;
    AlarmNews news = std::move(waiting_.front());
    waiting_.pop_front();
    std::erase_if(standing_,
                  [&](const Standing& one) { return one.news.alarm.id == news.alarm.id; });
    if (news.kind == NewsKind::resolved || news.alarm.kind != "cell.silent") return;
    news.kind = NewsKind::repeat;
    standing_.push_back({std::move(news), monotonic_s() + receiver_.repeat_h * 3600});
  }

  void repeat_what_stands() {
    if (receiver_.repeat_h <= 0) return;
    for (auto& one : standing_) {
      const bool queued = std::ranges::any_of(
          waiting_, [&](const AlarmNews& news) { return news.alarm.id == one.news.alarm.id; });
      if (!queued && monotonic_s() >= one.repeat_at_s) waiting_.push_back(one.news);
    }
  }

  struct Standing {
    AlarmNews news;
    double repeat_at_s = 0;
  };
  boost::asio::io_context& context_;
  const ReceiverDescription& receiver_;
  Notifier& notifier_;
  const std::function<void(const std::string&)>& say_;
  std::deque<AlarmNews> waiting_;
  std::vector<Standing> standing_;
  bool under_way_ = false;
  double retry_s_ = 0, next_try_s_ = 0;
  boost::asio::thread_pool thread_{1};
};

}  // namespace

Result<void> run_watchdog(WatchdogOptions options, Notifier& notifier,
                          const std::function<void(const std::string& address)>& ready,
                          const std::function<void(const std::string& line)>& say,
                          const std::function<bool()>& over) {
  DRIFTWISE_TRY(auto heads, HeadsLog::open(options.heads));
  boost::asio::io_context context(1);
  WatchBook book(options.silent_after_s);
  for (const auto& cell : options.expect) book.expect(cell, monotonic_s(), utc_now());
  // A cell that spoke before this program's start is expected to go on.
  for (const auto& [cell, kept] : heads.newest()) book.expect(cell, monotonic_s(), utc_now());
  Outbox outbox(context, options.receiver, notifier, say);
  const auto take = [&](const LifeSign& sign) -> Result<void> {
    if (!book.has_room_for(sign.cell))
      return fail(
          ErrorCode::invalid_argument, reasons::kBadLifeSign,
          "a sign of life of " + sign.cell + ": this watchdog has as many cells as it takes");
    const auto known = heads.newest().find(sign.cell);
    const ChainHead before = known == heads.newest().end() ? ChainHead{} : known->second.head;
    outbox.add(book.take(sign, before, monotonic_s(), utc_now()));
    return heads.keep(sign.cell, utc_now(), sign.head);
  };
  DRIFTWISE_TRY(
      const auto door,
      WatchdogDoor::open(context.get_executor(),
                         {options.listen, std::move(options.token), std::move(options.tls)}, take));
  ready(door->address());
  while (!over()) {
    context.run_for(std::chrono::milliseconds(200));
    context.restart();
    outbox.add(book.look(monotonic_s(), utc_now()));
    outbox.look();
  }
  return {};
}

}  // namespace driftwise::watchdog
