#include "server/watchdog/watchdog.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <deque>
#include <list>

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
      waiting_.push_back({std::move(one), utc_now(), receiver_.to});
    }
  }

  void look() {
    repeat_what_stands();
    if (under_way_) return;
    const auto late = std::ranges::find_if(
        late_, [](const Late& one) { return monotonic_s() >= one.next_try_s; });
    if (late != late_.end()) {
      sending_ = late;
      send(late->message);
    } else if (!waiting_.empty() && monotonic_s() >= next_try_s_) {
      sending_ = late_.end();
      send(waiting_.front());
    }
  }

 private:
  struct Waiting {
    AlarmNews news;
    UtcTime at;                   // of its first try: a mail keeps its Message-ID
    std::vector<std::string> to;  // of a mail
  };

  // The cell's own command would ask the daemon that is silent, and its numbers are others.
  std::string remedy_of(const AlarmNews& news) const {
    if (news.kind == NewsKind::resolved) return "nothing to do: the cell speaks again";
    if (news.alarm.kind != "cell.silent")
      return "look at the record of this cell before anything is added to it; this is told once";
    return "go and look at the cell: its computer, its daemon (systemctl status driftwised), the "
           "network; " +
           (receiver_.repeat_h > 0
                ? fmt::format("this is told again every {:g} h until it speaks", receiver_.repeat_h)
                : std::string("this is told once"));
  }

  // Some recipients of a mail have it, these do not yet: they delay nobody else.
  struct Late {
    Waiting message;
    double retry_s = 1, next_try_s = 0;
  };

  void send(const Waiting& message) {
    under_way_ = true;
    Notice notice{message.news.alarm.subject, "", message.at, {message.news}, false};
    notice.is_of_record = false;
    notice.remedy = remedy_of(message.news);
    ReceiverDescription receiver = receiver_;
    receiver.to = message.to;
    boost::asio::post(thread_, [this, receiver = std::move(receiver), notice = std::move(notice)] {
      auto said = notifier_.tell(receiver, notice);
      boost::asio::post(context_, [this, said = std::move(said)] {
        under_way_ = false;
        say_(said ? "delivered: " + said->said
                  : "not delivered, tried again: " + said.error().message);
        if (sending_ == late_.end())
          told(said);
        else
          told_late(said);
      });
    });
  }

  void told_late(const Result<Delivery>& said) {
    if (said || said.error().code == ErrorCode::failed_precondition) {  // refused for good
      if (!said) say_("given up for " + sending_->message.to.front());
      late_.erase(sending_);
      return;
    }
    sending_->retry_s = std::min(2 * sending_->retry_s, kLongestRetry_s);
    sending_->next_try_s = monotonic_s() + sending_->retry_s;
  }

  void told(const Result<Delivery>& said) {
    if (!said) {
      retry_s_ = std::clamp(2 * retry_s_, 1.0, kLongestRetry_s);
      next_try_s_ = monotonic_s() + retry_s_;
      return;
    }
    retry_s_ = next_try_s_ = 0;
    const Waiting message = std::move(waiting_.front());
    waiting_.pop_front();
    for (const auto& one : said->refused)
      if (one.for_now)
        late_.push_back({{message.news, message.at, {one.address}}, 1, monotonic_s() + 1});
    AlarmNews news = message.news;
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
          waiting_, [&](const Waiting& it) { return it.news.alarm.id == one.news.alarm.id; });
      if (!queued && monotonic_s() >= one.repeat_at_s)
        waiting_.push_back({one.news, utc_now(), receiver_.to});
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
  std::deque<Waiting> waiting_;
  std::list<Late> late_;
  std::list<Late>::iterator sending_ = late_.end();  // end: the first that waits
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
