#pragma once
// The clock that the daemon and a simulated cell share: 40 bytes, little-endian, mapped into both
// processes.
//
//   char magic[8] = "DWCLOCK1"; u64 sequence; i64 anchor_wall_ns; i64 anchor_cell_ns; f64 speed
//   cell_ns = anchor_cell_ns + (wall_ns - anchor_wall_ns) * speed, wall = CLOCK_REALTIME
//
// The sequence is odd while the three values are being written: a reader that saw an odd or a
// changed one reads again. The simulated cell creates the file; afterwards the daemon alone writes
// it.

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "server/core/result.h"

namespace driftwise::application {

struct ClockAnchor {
  std::int64_t wall_ns = 0, cell_ns = 0;
  double speed = 1;

  std::int64_t cell_from_wall(std::int64_t at_wall_ns) const {
    // The difference stays small enough for a double to hold nanoseconds for 100 days.
    return cell_ns + static_cast<std::int64_t>(static_cast<double>(at_wall_ns - wall_ns) * speed);
  }
};

// The anchor for readers on any thread, without a lock: one writer, and a reader that met a change
// reads again.
class SharedAnchor {
 public:
  explicit SharedAnchor(const ClockAnchor& anchor) { write(anchor); }
  ClockAnchor read() const;
  void write(const ClockAnchor& anchor);  // one thread

 private:
  std::atomic<std::uint64_t> sequence_{0};
  std::atomic<std::int64_t> wall_ns_, cell_ns_;
  std::atomic<double> speed_;
};

class ClockFile {
 public:
  // Errors: not_found NO_CLOCK_FILE; data_loss BAD_CLOCK_FILE (size, magic, a speed that is no
  // positive number).
  static Result<std::unique_ptr<ClockFile>> open(const std::string& path);
  // Creates it, or overwrites what is there. For tests and for a cell without a simulated one.
  static Result<std::unique_ptr<ClockFile>> create(const std::string& path,
                                                   const ClockAnchor& anchor);
  ~ClockFile();
  ClockFile(const ClockFile&) = delete;
  ClockFile& operator=(const ClockFile&) = delete;

  ClockAnchor read() const;               // any thread
  void write(const ClockAnchor& anchor);  // one thread

 private:
  explicit ClockFile(void* mapped) : mapped_(mapped) {}
  void* mapped_;
};

}  // namespace driftwise::application
