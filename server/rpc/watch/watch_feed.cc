#include "server/rpc/watch/watch_feed.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <mutex>

#include "server/application/alarms/alarms.h"
#include "server/application/diagnoses/diagnoses.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/ports/host.h"
#include "server/application/runs/runs.h"
#include "server/application/status/overview.h"
#include "server/application/watching/feeds.h"
#include "server/core/try.h"
#include "server/rpc/cell/convert_cell.h"
#include "server/rpc/diagnosis/convert_diagnosis.h"
#include "server/rpc/run/convert_run.h"
#include "server/rpc/shared/source_task.h"
#include "server/rpc/watch/convert_watch.h"

namespace driftwise::rpc {
namespace {

using WallClock = std::chrono::steady_clock;
constexpr auto kLookEvery = std::chrono::milliseconds(50);
constexpr auto kCellEvery = std::chrono::seconds(1);
constexpr auto kAfterABug = std::chrono::seconds(1);
constexpr int kPageRecords = 500;
constexpr std::size_t kMostAlarms = 500;  // as a list of alarms
constexpr std::size_t kEventsKept = 20'000;

WatchChunk chunk_of(const RecordCursor& from, const RecordPage& page) {
  return {from, page.to, watch_events_from(page)};
}

bool same_columns(const v1::ChannelLayout& a, const v1::ChannelLayout& b) {
  if (a.columns_size() != b.columns_size()) return false;
  for (int i = 0; i < a.columns_size(); ++i)
    if (a.columns(i).SerializeAsString() != b.columns(i).SerializeAsString()) return false;
  return true;
}

Result<RecordHead> read_head(Store& store) {
  DRIFTWISE_TRY(auto database, store.records().database_id());
  DRIFTWISE_TRY(const auto newest, store.records().newest());
  return RecordHead{std::move(database), newest};
}

}  // namespace

// The cell's executor may still have news on its way when the watch thread ends.
class WatchFeed::Back {
 public:
  explicit Back(asio::any_io_executor watch_thread) : watch_thread_(std::move(watch_thread)) {}
  template <class Handler>
  void post(Handler handler) {
    const std::lock_guard lock(mutex_);
    if (open_) asio::post(watch_thread_, std::move(handler));
  }
  void close() {
    const std::lock_guard lock(mutex_);
    open_ = false;
  }

 private:
  std::mutex mutex_;
  bool open_ = true;
  asio::any_io_executor watch_thread_;
};

class WatchFeed::Look : public std::enable_shared_from_this<Look> {
 public:
  Look(const application::Services& cell, std::shared_ptr<Back> back)
      : cell_(cell), back_(std::move(back)) {}

  void begin(std::weak_ptr<WatchFeed> feed) {
    asio::post(cell_.host.executor(), [self = shared_from_this(), feed = std::move(feed)] {
      self->feed_ = feed;
      self->values_news_ = self->progress_news_ = self->jobs_news_ = true;  // for who comes anew
      if (self->wanted_++ == 0 && !self->running_) {
        self->running_ = true;
        spawn(self->cell_.host.executor(), look_for_ever(self));
      }
    });
  }
  void end() {
    asio::post(cell_.host.executor(), [self = shared_from_this()] { --self->wanted_; });
  }

 private:
  static Awaitable<void> look_for_ever(std::shared_ptr<Look> self) {
    asio::steady_timer timer(self->cell_.host.executor());
    auto due = std::chrono::steady_clock::now();
    while (self->wanted_ > 0) {
      // By the clock, not after the work: twenty looks a second are twenty.
      auto next = due + kLookEvery;
      try {
        auto looking = look(self);
        co_await std::move(looking);
      } catch (const std::exception& bug) {
        static_cast<void>(error_of_exception(bug));
        self->watches_.clear();  // the next look watches and reads anew
        next = std::chrono::steady_clock::now() + kAfterABug;
      }
      due = std::max(next, std::chrono::steady_clock::now());
      timer.expires_at(due);
      co_await timer.async_wait(asio::as_tuple(asio::use_awaitable));
    }
    self->watches_.clear();
    self->running_ = false;
  }

  static Awaitable<void> look(std::shared_ptr<Look> self) {
    self->watch_again();
    News news;
    self->look_at_states(news);
    if (std::exchange(self->records_news_, false)) {
      auto reading = self->read_records(news);
      co_await std::move(reading);
    }
    news.head = self->head_;
    // After the record was read: what it has by then is not told as missing there.
    if (news.cell) news.alarms = self->cell_.alarms.unwritten(kMostAlarms);
    if (news.values || news.cell || news.progress || news.jobs || !news.pages.empty())
      self->send(std::move(news));
  }

  void watch_again() {
    if (!watches_.empty()) return;
    values_news_ = progress_news_ = records_news_ = true;
    head_ = {};
    watches_.push_back(cell_.feeds.watch_readings([this](const Reading&) { values_news_ = true; }));
    watches_.push_back(
        cell_.runs.watch([this](const application::RunProgress&) { progress_news_ = true; }));
    watches_.push_back(cell_.feeds.watch_records([this] { records_news_ = true; }));
    diagnoses_.clear();
    improvements_.clear();
    watches_.push_back(cell_.diagnoses.watch(
        [this](const application::DiagnosisProgress& job) { note(diagnoses_, job); }));
    watches_.push_back(cell_.improvements.watch(
        [this](const application::ImprovementProgress& job) { note(improvements_, job); }));
  }

  // How one ended is on record: who has left the list here is told from there.
  template <class Id, class Progress>
  void note(std::map<Id, Progress>& under_way, const Progress& job) {
    jobs_news_ = true;
    if (job.state == JobState::running)
      under_way[job.id] = job;
    else
      under_way.erase(job.id);
  }

  void look_at_states(News& news) {
    const auto now = WallClock::now();
    news.jobs = std::exchange(jobs_news_, false);
    if (news.jobs) {
      for (const auto& [id, job] : diagnoses_) news.diagnoses.push_back(job);
      for (const auto& [id, job] : improvements_) news.improvements.push_back(job);
    }
    news.values = std::exchange(values_news_, false);
    news.progress = std::exchange(progress_news_, false);
    news.cell = records_news_ || now >= cell_due_;
    if (!news.values && !news.progress && !news.cell) return;
    if (news.cell) cell_due_ = now + kCellEvery;
    news.values = news.values || news.cell;  // ages grow
    news.status = std::make_shared<const application::CellStatus>(cell_.overview.status());
  }

  Awaitable<void> read_records(News& news) {
    const auto head = co_await cell_.records.call(read_head);
    if (!head) {
      spdlog::warn("watching: {}", head.error().message);
      co_return;
    }
    if (head_.database.empty()) head_ = *head;  // what was before is read by those who ask for it
    RecordCursor at = head_.newest;
    while (at != head->newest) {
      auto reading = cell_.records.records().records(at, head->newest, kPageRecords);
      auto page = co_await std::move(reading);
      if (!page) {
        spdlog::warn("watching: {}", page.error().message);
        break;
      }
      const RecordCursor to = page->to;
      news.pages.emplace_back(at, std::move(*page));
      at = to;
    }
    head_.newest = at;
    records_news_ = records_news_ || at != head->newest;
  }

  void send(News news) {
    auto shared = std::make_shared<News>(std::move(news));
    back_->post([feed = feed_, shared] {
      if (const auto alive = feed.lock()) alive->take(std::move(*shared));
    });
  }

  application::Services cell_;
  std::shared_ptr<Back> back_;
  std::weak_ptr<WatchFeed> feed_;
  int wanted_ = 0;
  bool running_ = false;
  bool values_news_ = false, progress_news_ = false, records_news_ = false, jobs_news_ = false;
  std::map<DiagnosisId, application::DiagnosisProgress> diagnoses_;  // under way
  std::map<ImprovementId, application::ImprovementProgress> improvements_;
  WallClock::time_point cell_due_{};
  RecordHead head_;
  std::vector<std::shared_ptr<void>> watches_;
};

WatchFeed::WatchFeed(const application::Services& cell, asio::any_io_executor watch_thread)
    : cell_(cell),
      watch_thread_(watch_thread),
      back_(std::make_shared<Back>(std::move(watch_thread))),
      look_(std::make_shared<Look>(cell, back_)) {}

WatchFeed::~WatchFeed() { back_->close(); }

std::shared_ptr<void> WatchFeed::subscribe(std::function<void()> wake) {
  const std::int64_t key = ++last_subscription_;
  if (wakes_.empty()) {  // nobody has looked for a while: what is known is old
    tick_.reset();
    chunks_.clear();
    events_kept_ = 0;
  }
  wakes_.emplace(key, std::move(wake));
  look_->begin(weak_from_this());
  return std::shared_ptr<void>(this, [weak = weak_from_this(), key, look = look_](void*) {
    look->end();
    if (const auto alive = weak.lock()) alive->wakes_.erase(key);
  });
}

void WatchFeed::take_states(const News& news, WatchTick& tick) {
  if (news.jobs) {
    tick.jobs.clear();
    for (const auto& job : news.diagnoses)
      *tick.jobs.emplace_back().mutable_diagnosis() = diagnosis_progress_from(job);
    for (const auto& job : news.improvements)
      *tick.jobs.emplace_back().mutable_improvement() = improvement_progress_from(job);
    ++tick.jobs_number;
  }
  if (!news.status) return;
  const auto& status = *news.status;
  tick.cell_time = status.now.utc;
  auto layout = layout_from(status);
  if (!same_columns(layout, tick.layout)) {
    layout.set_revision(tick.layout.revision() + 1);
    tick.layout = std::move(layout);
  }
  tick.values = values_update_from(status);
  tick.values.set_layout_revision(tick.layout.revision());
  tick.values_number += news.values ? 1 : 0;
  if (news.cell) {
    tick.cell = status_from(status);
    tick.cell.clear_values();
    ++tick.cell_number;
    std::vector<v1::WatchEvent> alarms;
    for (const auto& alarm : news.alarms)
      *alarms.emplace_back().mutable_alarm() = alarm_from(alarm);
    if (!std::ranges::equal(alarms, tick.alarms, {}, &v1::WatchEvent::SerializeAsString,
                            &v1::WatchEvent::SerializeAsString)) {
      tick.alarms = std::move(alarms);
      ++tick.alarms_number;
    }
  }
  if (news.progress) {
    tick.progress = status.run ? std::optional(progress_from(*status.run)) : std::nullopt;
    ++tick.progress_number;
  }
}

void WatchFeed::take(News news) {
  auto tick = tick_ ? std::make_shared<WatchTick>(*tick_) : std::make_shared<WatchTick>();
  take_states(news, *tick);
  if (!news.head.database.empty()) tick->head = {news.head.database, news.head.newest};
  tick_ = std::move(tick);
  for (const auto& [from, page] : news.pages) {
    if (!chunks_.empty() && chunks_.back()->to != from) {  // a look of before
      chunks_.clear();
      events_kept_ = 0;
    }
    chunks_.push_back(std::make_shared<const WatchChunk>(chunk_of(from, page)));
    events_kept_ += chunks_.back()->events.size();
  }
  forget_oldest();
  const auto wakes = wakes_;  // one that is woken may leave
  for (const auto& [key, wake] : wakes) wake();
}

void WatchFeed::forget_oldest() {
  while (events_kept_ > kEventsKept) {
    events_kept_ -= chunks_.front()->events.size();
    chunks_.pop_front();
  }
}

std::shared_ptr<const WatchChunk> WatchFeed::chunk_after(const RecordCursor& cursor) const {
  for (auto one = chunks_.rbegin(); one != chunks_.rend(); ++one)
    if ((*one)->from == cursor) return *one;
  return nullptr;
}

void WatchFeed::fetch(const RecordCursor& after, const RecordCursor& until,
                      std::function<void(Result<WatchChunk>)> then) {
  const auto ask = [](application::StoreReader& records, RecordCursor from, RecordCursor to,
                      std::shared_ptr<Back> back, std::weak_ptr<WatchFeed> feed,
                      std::function<void(Result<WatchChunk>)> answer) -> Awaitable<void> {
    auto reading = without_exception(records.records().records(from, to, kPageRecords));
    auto page = co_await std::move(reading);
    auto shared = std::make_shared<Result<RecordPage>>(std::move(page));
    back->post([shared, from, feed, answer] {
      if (feed.expired()) return;
      if (*shared)
        answer(chunk_of(from, **shared));
      else
        answer(tl::unexpected(shared->error()));
    });
  };
  spawn(cell_.host.executor(),
        ask(cell_.records, after, until, back_, weak_from_this(), std::move(then)));
}

}  // namespace driftwise::rpc
