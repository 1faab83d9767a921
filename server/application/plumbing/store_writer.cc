#include "server/application/plumbing/store_writer.h"

#include <algorithm>
#include <iterator>

#include "server/application/plumbing/crash_point.h"

namespace driftwise::application {
namespace {

template <class Record, class Instant>
void put_back_by(std::vector<Record>& waiting, std::vector<Record> back, Instant instant) {
  back.insert(back.end(), std::make_move_iterator(waiting.begin()),
              std::make_move_iterator(waiting.end()));
  std::ranges::stable_sort(back, {}, instant);
  waiting = std::move(back);
}

}  // namespace

StoreWriter::StoreWriter(const asio::any_io_executor& thread, std::unique_ptr<Store> store)
    : AsyncStore(thread, thread, std::move(store)) {}

StoreWriter::~StoreWriter() = default;

void StoreWriter::add(Reading reading) {
  if (readings_.size() >= kMaxReadings) {
    ++dropped_;
    return;
  }
  readings_.push_back(std::move(reading));
}

void StoreWriter::add(MoveRecord move) {
  if (moves_.size() < kMaxReadings) moves_.push_back(std::move(move));
}

void StoreWriter::add(RejectedAnswer rejected) {
  if (rejected_.size() < kMaxReadings) rejected_.push_back(std::move(rejected));
}

std::optional<CellTime> StoreWriter::gathered_since() const {
  std::optional<CellTime> since;
  if (!readings_.empty()) since = readings_.front().end;
  if (!moves_.empty() && (!since || moves_.front().at.utc < *since)) since = moves_.front().at.utc;
  return since;
}

Awaitable<Result<std::optional<PointId>>> StoreWriter::commit(PointCommit commit) {
  // Shared with the writer's thread for the time of the call, so that a failure can hand it back
  // without a copy.
  auto parcel = std::make_shared<PointCommit>(std::move(commit));
  parcel->slow_readings = std::exchange(readings_, {});
  parcel->moves = std::exchange(moves_, {});
  parcel->rejected = std::exchange(rejected_, {});
  auto stored = co_await call(
      [](Store& store, const std::shared_ptr<PointCommit>& kept) {
        crash_point("before_point_commit");
        auto result = store.points().commit(*kept);
        if (result) crash_point("after_point_commit");
        return result;
      },
      parcel);
  if (!stored)
    put_back(std::move(parcel->slow_readings), std::move(parcel->moves),
             std::move(parcel->rejected));
  co_return stored;
}

Awaitable<Result<void>> StoreWriter::flush() {
  if (readings_.empty() && moves_.empty() && rejected_.empty()) co_return Result<void>{};
  auto parcel = std::make_shared<PointCommit>();
  parcel->slow_readings = std::exchange(readings_, {});
  parcel->moves = std::exchange(moves_, {});
  parcel->rejected = std::exchange(rejected_, {});
  auto stored = co_await call(
      [](Store& store, const std::shared_ptr<PointCommit>& kept) {
        crash_point("before_readings_commit");
        auto result = store.readings().append(kept->slow_readings, kept->moves, kept->rejected);
        if (result) crash_point("after_readings_commit");
        return result;
      },
      parcel);
  if (!stored)
    put_back(std::move(parcel->slow_readings), std::move(parcel->moves),
             std::move(parcel->rejected));
  co_return stored;
}

// A commit and a flush may be under way at a time, and both fail: what is put back last is not
// always the oldest.
void StoreWriter::put_back(std::vector<Reading> readings, std::vector<MoveRecord> moves,
                           std::vector<RejectedAnswer> rejected) {
  put_back_by(readings_, std::move(readings), [](const Reading& one) { return one.end; });
  put_back_by(moves_, std::move(moves), [](const MoveRecord& one) { return one.at.utc; });
  put_back_by(rejected_, std::move(rejected), [](const RejectedAnswer& one) { return one.start; });
}

}  // namespace driftwise::application
