#include "server/compensation/snapshot_board.h"

namespace driftwise::compensation {

SnapshotBoard::Read SnapshotBoard::read() const {
  for (;;) {
    const std::uint32_t index = current_.load();
    if (index == kNone) return {};
    const Slot& slot = slots_[index];
    slot.readers.fetch_add(1);
    if (current_.load() == index) return Read(&slot.snapshot, &slot.readers);
    slot.readers.fetch_sub(
        1);  // the writer moved on in between and may be filling this slot: not looked at
  }
}

bool SnapshotBoard::publish(Snapshot snapshot) {
  const std::uint32_t current = current_.load();
  for (std::uint32_t step = 1; step <= kSlots; ++step) {
    // The slot after the current one was left longest ago, so its readers are the likeliest to be
    // gone.
    const std::uint32_t index = current == kNone ? step - 1 : (current + step) % kSlots;
    Slot& slot = slots_[index];
    if (index == current || slot.readers.load() != 0) continue;
    slot.snapshot = std::move(snapshot);
    current_.store(index);
    generation_.fetch_add(1);
    return true;
  }
  return false;
}

}  // namespace driftwise::compensation
