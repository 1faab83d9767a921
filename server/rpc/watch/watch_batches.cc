#include "server/rpc/watch/watch_batches.h"

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cmath>
#include <deque>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/watch/convert_watch.h"
#include "server/rpc/watch/jobs_told.h"

namespace driftwise::rpc {
namespace {

using WallClock = std::chrono::steady_clock;
constexpr auto kHeartbeat = std::chrono::seconds(1);
constexpr int kMostEvents = 1000;  // of one batch

class BatchSource final : public StreamSource<v1::WatchResponse> {
 public:
  BatchSource(std::shared_ptr<WatchFeed> feed, WatchWish wish)
      : feed_(std::move(feed)),
        wish_(std::move(wish)),
        timer_(feed_->executor()),
        interval_(std::chrono::duration_cast<WallClock::duration>(
            std::chrono::duration<double>(1 / wish_.max_hz))) {}

  void start(std::function<void()> wake) override {
    wake_ = wake;
    subscription_ = feed_->subscribe(std::move(wake));
  }

  std::optional<v1::WatchResponse> next() override {
    const auto tick = feed_->tick();
    if (end_ || !tick || tick->head.database.empty() || !knows_where(*tick)) return std::nullopt;
    const auto now = WallClock::now();
    if (now < not_before_) return wait_until(not_before_);
    v1::WatchResponse response;
    add_states(*tick, response);
    add_records(*tick, response);
    if (end_) return std::nullopt;
    add_alarms(*tick, response);
    if (response.events().empty() && now < heartbeat_due_) return wait_until(heartbeat_due_);
    not_before_ = now + interval_;
    heartbeat_due_ = now + kHeartbeat;
    response.set_cursor(cursor_text({tick->head.database, *at_}));
    *response.mutable_server_time() = timestamp_from(UtcTime{
        std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count()});
    *response.mutable_cell_time() = timestamp_from(tick->cell_time);
    return response;
  }
  std::optional<Result<void>> ended() override { return end_; }

 private:
  bool wants(v1::Topic topic) const { return wish_.topics.empty() || wish_.topics.contains(topic); }

  // The client's place in the record, once the record's end is known.
  bool knows_where(const WatchTick& tick) {
    if (at_) return true;
    if (wish_.cursor.empty()) {
      at_ = tick.head.records;
      return true;
    }
    const auto cursor = cursor_from(wish_.cursor);
    if (cursor && is_known_cursor(*cursor, tick.head)) {
      at_ = cursor->records;
      return true;
    }
    end_ = fail(ErrorCode::out_of_range, reasons::kCursorTooOld,
                "cursor '" + wish_.cursor.substr(0, 100) +
                    "' is none of this database: load afresh, and watch without a cursor");
    return false;
  }

  std::nullopt_t wait_until(WallClock::time_point instant) {
    timer_.expires_at(instant);
    timer_.async_wait([wake = wake_](const boost::system::error_code& cancelled) {
      if (!cancelled) wake();
    });
    return std::nullopt;
  }

  void add_states(const WatchTick& tick, v1::WatchResponse& out) {
    if (wants(v1::TOPIC_VALUES) && tick.values_number > values_sent_) {
      if (std::exchange(layout_sent_, tick.layout.revision()) != tick.layout.revision())
        *out.add_events()->mutable_layout() = tick.layout;
      *out.add_events()->mutable_values() = tick.values;
      values_sent_ = tick.values_number;
    }
    if (wants(v1::TOPIC_CELL) && tick.cell_number > cell_sent_) {
      *out.add_events()->mutable_cell() = tick.cell;
      cell_sent_ = tick.cell_number;
    }
    if (wants(v1::TOPIC_RUNS) && tick.progress_number > progress_sent_) {
      if (tick.progress) *out.add_events()->mutable_progress() = *tick.progress;
      progress_sent_ = tick.progress_number;
    }
    if (wants(v1::TOPIC_DIAGNOSES) && tick.jobs_number > jobs_sent_) {
      for (const auto& job : tick.jobs)
        if (auto event = jobs_told_.from_cell(job)) *out.add_events() = std::move(*event);
      jobs_sent_ = tick.jobs_number;
    }
  }

  // Behind the records, which may say what was before.
  void add_alarms(const WatchTick& tick, v1::WatchResponse& out) {
    if (!wants(v1::TOPIC_ALARMS) || *at_ != tick.head.records || tick.alarms_number <= alarms_sent_)
      return;
    for (const auto& alarm : tick.alarms) *out.add_events() = alarm;
    alarms_sent_ = tick.alarms_number;
  }

  void add_records(const WatchTick& tick, v1::WatchResponse& out) {
    while (*at_ != tick.head.records && out.events_size() < kMostEvents) {
      auto chunk = fetched_ && fetched_->from == *at_ ? std::exchange(fetched_, nullptr)
                                                      : feed_->chunk_after(*at_);
      if (!chunk) return fetch(tick.head.records);
      for (const auto& one : chunk->events) {
        if (!wants(topic_of(one))) continue;
        if (auto event = jobs_told_.from_record(one)) *out.add_events() = std::move(*event);
      }
      at_ = chunk->to;
    }
    if (*at_ != tick.head.records) wake_();  // the rest with the next batch
  }

  void fetch(const RecordCursor& until) {
    if (std::exchange(fetching_, true)) return;
    feed_->fetch(*at_, until, [this, alive = std::weak_ptr(alive_)](Result<WatchChunk> chunk) {
      if (alive.expired()) return;
      fetching_ = false;
      if (chunk)
        fetched_ = std::make_shared<const WatchChunk>(std::move(*chunk));
      else
        end_ = tl::unexpected(chunk.error());
      wake_();
    });
  }

  std::shared_ptr<WatchFeed> feed_;
  WatchWish wish_;
  boost::asio::steady_timer timer_;
  WallClock::duration interval_;
  WallClock::time_point not_before_{}, heartbeat_due_{};
  std::optional<RecordCursor> at_;
  std::shared_ptr<const WatchChunk> fetched_;
  bool fetching_ = false;
  std::int64_t layout_sent_ = 0, values_sent_ = 0, cell_sent_ = 0, progress_sent_ = 0,
               jobs_sent_ = 0, alarms_sent_ = 0;
  JobsTold jobs_told_;
  std::function<void()> wake_;
  std::optional<Result<void>> end_;
  std::shared_ptr<int> alive_ = std::make_shared<int>();
  std::shared_ptr<void> subscription_;
};

}  // namespace

Result<WatchWish> watch_wish_from(const v1::WatchRequest& request) {
  constexpr double kUsualHz = 10, kMostHz = 20;
  WatchWish wish;
  wish.cursor = request.cursor();
  if (!std::isfinite(request.max_hz()) || request.max_hz() < 0 || request.max_hz() > kMostHz)
    return fail(ErrorCode::invalid_argument, reasons::kBadRate,
                "max_hz: found " + formats::number_text(request.max_hz()) + ", expected 0 to 20");
  wish.max_hz = request.max_hz() == 0 ? kUsualHz : request.max_hz();
  for (const int topic : request.topics()) {
    if (topic == v1::TOPIC_UNSPECIFIED || !v1::Topic_IsValid(topic))
      return fail(ErrorCode::invalid_argument, reasons::kBadTopic,
                  "topics: found " + std::to_string(topic) + ", expected those of Topic");
    wish.topics.insert(static_cast<v1::Topic>(topic));
  }
  return wish;
}

std::unique_ptr<StreamSource<v1::WatchResponse>> watch_batches(std::shared_ptr<WatchFeed> feed,
                                                               WatchWish wish) {
  return std::make_unique<BatchSource>(std::move(feed), std::move(wish));
}

}  // namespace driftwise::rpc
