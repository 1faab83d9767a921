#pragma once
// A database that takes neither changes of the queue nor alarms while its disk is full.

#include <memory>
#include <optional>

#include "server/core/ports/store.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {

struct QueueRefusals {
  bool of_changes = false, of_alarms = false;
  int changes = 0;  // that were refused
};

class QueueWithoutRoom final : public Store, QueueStore, AlarmStore {
 public:
  QueueWithoutRoom(std::unique_ptr<Store> inner, QueueRefusals& refusals)
      : Store(before(*inner, this)), inner_(std::move(inner)), refusals_(refusals) {}

 private:
  static StoreParts before(Store& inner, QueueWithoutRoom* its) {
    StoreParts parts = inner.parts();
    parts.queue = its;
    parts.alarms = its;
    parts.upkeep = nullptr;
    return parts;
  }
  static tl::unexpected<Error> refused() {
    return fail(ErrorCode::resource_exhausted, "DISK_FULL", "the disk is full: make room");
  }
  Result<QueueRecord> queue(int history) override { return inner_->queue().queue(history); }
  Result<void> change_queue(const QueueChange& change) override {
    if (!refusals_.of_changes) return inner_->queue().change_queue(change);
    ++refusals_.changes;
    return refused();
  }
  Result<AlarmRecord> raise(const AlarmRecord& alarm) override {
    if (refusals_.of_alarms) return refused();
    return inner_->alarms().raise(alarm);
  }
  Result<AlarmRecord> tell(AlarmId id, const std::string& message,
                           const std::vector<std::string>& consequences) override {
    return inner_->alarms().tell(id, message, consequences);
  }
  Result<AlarmRecord> clear(AlarmId id, CellTime at) override {
    return inner_->alarms().clear(id, at);
  }
  Result<AlarmRecord> acknowledge(AlarmId id, CellTime at, const std::string& who) override {
    return inner_->alarms().acknowledge(id, at, who);
  }
  Result<std::vector<AlarmRecord>> alarms(bool with_history, int limit) override {
    return inner_->alarms().alarms(with_history, limit);
  }
  Result<AlarmRecord> shelve(AlarmId id, const AlarmShelf& shelf) override {
    return inner_->alarms().shelve(id, shelf);
  }
  Result<AlarmRecord> unshelve(AlarmId id, CellTime at) override {
    return inner_->alarms().unshelve(id, at);
  }
  Result<std::vector<AlarmRecord>> end_shelves(CellTime now) override {
    return inner_->alarms().end_shelves(now);
  }
  Result<void> idle() override { return inner_->idle(); }

  std::unique_ptr<Store> inner_;
  QueueRefusals& refusals_;
};

// Of the real store, for a cell in memory; the refusals outlive it.
inline OpenStore queue_without_room(QueueRefusals& refusals) {
  return [&refusals](const std::string& path, bool read_only) -> Result<std::unique_ptr<Store>> {
    auto store = kSqlite(path, read_only);
    if (!store) return store;
    return std::unique_ptr<Store>(new QueueWithoutRoom(std::move(*store), refusals));
  };
}

}  // namespace driftwise::tests
