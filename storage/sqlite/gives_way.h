#pragma once
// End of long statements for somebody who waits: give_way is asked about every millisecond while a
// statement of the connection runs, and ends it with a failure where it says so. One at a time for
// each connection.

#include <sqlite3.h>

#include <functional>

#include "storage/sqlite/database.h"

namespace driftwise::storage {

class GivesWay {
 public:
  // give_way: outlives this; empty: nothing gives way.
  GivesWay(Database& db, const std::function<bool()>& give_way) : db_(db), give_way_(give_way) {
    if (give_way_) sqlite3_progress_handler(db_.handle(), kOpsBetweenLooks, &GivesWay::asked, this);
  }
  ~GivesWay() {
    if (give_way_) sqlite3_progress_handler(db_.handle(), 0, nullptr, nullptr);
  }
  GivesWay(const GivesWay&) = delete;
  GivesWay& operator=(const GivesWay&) = delete;
  bool gave_way() const { return gave_way_; }

 private:
  static constexpr int kOpsBetweenLooks = 5'000;  // of SQLite's machine: about a millisecond
  static int asked(void* self) {
    auto& one = *static_cast<GivesWay*>(self);
    one.gave_way_ = one.give_way_();
    return one.gave_way_ ? 1 : 0;
  }
  Database& db_;
  const std::function<bool()>& give_way_;
  bool gave_way_ = false;
};

}  // namespace driftwise::storage
