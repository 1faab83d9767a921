#include <deque>

#include "server/application/plumbing/store_reader.h"
#include "server/application/ports/host.h"
#include "server/application/watching/feeds.h"
#include "server/rpc/cell/convert_cell.h"
#include "server/rpc/shared/source_task.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using application::Feeds;
using application::Host;
using application::StoreReader;

constexpr int kBatch = 100;

struct EventsState {              // shared with the fetch, which may end after the client has gone
  std::optional<EventId> cursor;  // the last event fetched; none until the first one happens
  EventRecord newest;             // as announced
  std::deque<EventRecord> batch;  // fetched, not sent yet
  bool fetching = false, more = false;
  std::optional<Result<void>> end;
  std::function<void()> wake;
};

Awaitable<void> fetch(StoreReader& records, std::shared_ptr<EventsState> state) {
  state->more = false;
  const EventRecord announced = state->newest;  // before: what comes meanwhile is fetched next
  auto events = co_await records.events().events(*state->cursor, kBatch);
  state->fetching = false;
  if (!events) {
    state->end = tl::unexpected(events.error());
    co_return state->wake();
  }
  // Announced, but not in the record yet: the announcement holds all of it.
  if (events->empty() && announced.id > *state->cursor) events->push_back(announced);
  for (auto& event : *events) {
    if (event.id <= *state->cursor) continue;
    state->cursor = event.id;
    state->batch.push_back(std::move(event));
  }
  if (!state->batch.empty())
    state->more = true;  // what came meanwhile is looked for when these are sent
  state->wake();
}

class EventSource final : public StreamSource<v1::WatchEventsResponse> {
 public:
  EventSource(const Host& host, Feeds& feeds, StoreReader& records, std::optional<EventId> after)
      : host_(host), feeds_(feeds), records_(records) {
    state_->cursor = after;
  }
  ~EventSource() override {
    state_->wake = [] {};
  }

  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    state_->more = state_->cursor.has_value();
    watch_ = feeds_.watch_events([state = state_](const EventRecord& event) {
      if (!state->cursor) state->cursor = EventId{event.id.value - 1};
      if (event.id > state->newest.id) state->newest = event;
      state->more = true;
      state->wake();
    });
  }

  std::optional<v1::WatchEventsResponse> next() override {
    if (state_->batch.empty()) {
      if (state_->more && !state_->fetching && !state_->end) {
        state_->fetching = true;
        spawn_for_source(host_.executor(), fetch(records_, state_), state_);
      }
      return std::nullopt;
    }
    v1::WatchEventsResponse response;
    *response.mutable_event() = event_from(state_->batch.front());
    state_->batch.pop_front();
    return response;
  }
  std::optional<Result<void>> ended() override { return state_->end; }

 private:
  const Host& host_;
  Feeds& feeds_;
  StoreReader& records_;
  std::shared_ptr<EventsState> state_ = std::make_shared<EventsState>();
  std::shared_ptr<void> watch_;
};

}  // namespace

std::unique_ptr<StreamSource<v1::WatchEventsResponse>> watch_events(const Host& host, Feeds& feeds,
                                                                    StoreReader& records,
                                                                    std::optional<EventId> after) {
  return std::make_unique<EventSource>(host, feeds, records, after);
}

}  // namespace driftwise::rpc
