#pragma once
// Series by the pixel. Readings are summarised in steps by the writer, in between its commits;
// series() reads the summaries and adds what is not in them yet. docs/performance.md has figures.

#include "server/core/ports/watch_store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteSeriesStore final : public SeriesStore {
 public:
  static constexpr std::int64_t kReadingsPerStep = 2048;

  explicit SqliteSeriesStore(Session& session) : session_(session) {}
  Result<SeriesAnswer> series(const SeriesQuery& query) override;
  Result<bool> summarise() override;
  // One step where it is worth its price: each rewrites the last block of every channel.
  Result<void> keep_up();

 private:
  Session& session_;
};

}  // namespace driftwise::storage
