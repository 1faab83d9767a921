#pragma once
// The one writing store and the one thread it lives on.
//
// The recorder's readings and the engine's moves gather here and go to disk together: with the next
// point's commit, or by flush(). A failed write puts them back, in order, so that a full disk loses
// nothing while there is room: kMaxReadings of them (about a day of three devices). Beyond that the
// newest are dropped and counted: what is kept then adjoins what is on disk, and the gap has one
// beginning and one end, both in the events. A kill loses what gathered since the last write:
// seconds of slow channels, never a point.

#include <boost/asio/any_io_executor.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "server/application/plumbing/async_store.h"

namespace driftwise::application {

class StoreWriter : public AsyncStore {
 public:
  static constexpr std::size_t kMaxReadings = 50'000;

  // thread: an executor on which one thread at most runs; nobody else may touch the store.
  StoreWriter(const asio::any_io_executor& thread, std::unique_ptr<Store> store);
  ~StoreWriter();

  void add(Reading reading);
  void add(MoveRecord move);
  void add(RejectedAnswer rejected);

  // Other calls are made in their order, by the functions of AsyncStore.

  // Durable when it returns. Takes the gathered readings and moves along; the caller's commit is
  // not consumed, so that the very same one can be tried again after resource_exhausted.
  Awaitable<Result<std::optional<PointId>>> commit(PointCommit commit);
  // Writes what has gathered; does nothing when that is nothing.
  Awaitable<Result<void>> flush();

  std::size_t gathered() const { return readings_.size(); }
  // Since when the oldest reading or move has waited; none when nothing does.
  std::optional<CellTime> gathered_since() const;
  std::int64_t dropped() const { return dropped_; }
  // Readings that come now are dropped: as many wait as may.
  bool is_dropping() const { return dropped_ > 0 && readings_.size() >= kMaxReadings; }

 private:
  void put_back(std::vector<Reading> readings, std::vector<MoveRecord> moves,
                std::vector<RejectedAnswer> rejected);

  std::vector<Reading> readings_;
  std::vector<MoveRecord> moves_;
  std::vector<RejectedAnswer> rejected_;
  std::int64_t dropped_ = 0;
};

}  // namespace driftwise::application
