#pragma once

#include "server/core/ports/store.h"
#include "storage/sqlite/session.h"

namespace driftwise::storage {

class SqliteReadingStore final : public ReadingStore {
 public:
  explicit SqliteReadingStore(Session& session) : session_(session) {}
  Result<void> append(std::span<const Reading> readings, std::span<const MoveRecord> moves,
                      std::span<const RejectedAnswer> rejected) override;
  Result<std::vector<Reading>> readings(const std::string& device, CellTime from, CellTime to,
                                        int limit) override;
  Result<std::vector<MoveRecord>> moves(CellTime from, CellTime to) override;

 private:
  Session& session_;
};

}  // namespace driftwise::storage
