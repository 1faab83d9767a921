#pragma once
// Stretches of time whose readings no thinning takes: around attempts, points and datums. Rows of
// an imported file do not count: they were measured elsewhere, and their times here are those of
// the import.
//
// Thread: the store's. Throws StorageFailure.

#include <cstdint>
#include <map>

#include "storage/sqlite/session.h"

namespace driftwise::storage {

// Readings that near to an attempt or a datum stay: its temperatures are interpolated from them.
inline constexpr std::int64_t kAroundAttempt_ns = 300'000'000'000;

class KeptStretches {
 public:
  // Rows stored since the last time, by their numbers: what is known is not read again.
  void read_on(Session& session);
  void forget() { *this = {}; }
  bool is_within(std::int64_t from_ns, std::int64_t to_ns) const;

 private:
  void add(std::int64_t from_ns, std::int64_t to_ns);

  std::map<std::int64_t, std::int64_t> ends_;  // by their begin; apart from one another
  std::int64_t attempt_ = 0, datum_ = 0, point_ = 0;
};

}  // namespace driftwise::storage
