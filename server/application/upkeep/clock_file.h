#pragma once
// The clock that the daemon and a simulated cell share: 64 bytes, little-endian, mapped into both
// processes.
//
//   char magic[8] = "DWCLOCK2"; u64 sequence; i64 anchor_boot_ns; i64 anchor_cell_ns; f64 speed;
//   i64 anchor_wall_ns; u8 boot[16]
//   cell_ns = anchor_cell_ns + (boot_ns - anchor_boot_ns) * speed, boot_ns = CLOCK_BOOTTIME
//
// CLOCK_BOOTTIME is one clock for all processes of one start of one computer; `boot` names that
// start (the digits of /proc/sys/kernel/random/boot_id). anchor_wall_ns is the UTC of the anchor,
// with which the simulated cell goes on after a new start. The sequence is odd while the values are
// being written: a reader that saw an odd or a changed one reads again. The simulated cell creates
// the file, and makes it anew when hours pass at once without a daemon. While a daemon runs, it
// alone writes the file.

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "server/core/result.h"

namespace driftwise::application {

struct ClockAnchor {
  std::int64_t boot_ns = 0, cell_ns = 0;
  double speed = 1;
  std::int64_t wall_ns = 0;  // of the file only

  std::int64_t cell_from_boot(std::int64_t at_boot_ns) const {
    // At speed 1 exact; else the difference stays small enough for a double to hold nanoseconds for
    // 100 days.
    const std::int64_t passed_ns = at_boot_ns - boot_ns;
    if (speed == 1) return cell_ns + passed_ns;
    return cell_ns + static_cast<std::int64_t>(static_cast<double>(passed_ns) * speed);
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
  std::atomic<std::int64_t> boot_ns_, cell_ns_;
  std::atomic<double> speed_;
};

class ClockFile {
 public:
  // boot: names the present start of the computer, as ComputerClock has it. Errors: not_found
  // NO_CLOCK_FILE; data_loss BAD_CLOCK_FILE (size, magic, a speed that is no positive number);
  // failed_precondition OLD_CLOCK_FILE (of an earlier start of the computer).
  static Result<std::unique_ptr<ClockFile>> open(const std::string& path, const std::string& boot);
  // Creates it, or overwrites what is there. For tests and for a cell without a simulated one.
  static Result<std::unique_ptr<ClockFile>> create(const std::string& path,
                                                   const ClockAnchor& anchor,
                                                   const std::string& boot);
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
