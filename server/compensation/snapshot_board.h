#pragma once
// Where the newest snapshot of a model, or of a serving plan, hangs: one writer, many readers, no
// lock.
//
// A fixed ring of slots, each with a count of its readers. A reader counts itself into the current
// slot and looks again whether it is still the current one; only then does it look inside. The
// writer fills a slot that is not current and has no reader, and makes it current. All four steps
// are sequentially consistent, so a writer that saw no reader and a reader that saw the slot
// current cannot both be right about the same slot. A reader never allocates, never waits for
// another reader, and repeats itself only when a publication came in between.
// (std::atomic<std::shared_ptr> takes a lock in GCC 12.)

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "server/compensation/snapshot.h"

namespace driftwise::compensation {

template <class Kept>
class Board {
 public:
  static constexpr std::size_t kSlots = 16;

  // Keeps the snapshot it points at in place. Hold it for one answer, not across a wait: a held
  // guard takes one of the slots away from the writer. Movable; must not outlive the board.
  class Read {
   public:
    Read() = default;
    Read(Read&& other) noexcept
        : snapshot_(std::exchange(other.snapshot_, nullptr)),
          readers_(std::exchange(other.readers_, nullptr)) {}
    Read& operator=(Read&& other) noexcept {
      if (this != &other) {
        release();
        snapshot_ = std::exchange(other.snapshot_, nullptr);
        readers_ = std::exchange(other.readers_, nullptr);
      }
      return *this;
    }
    ~Read() { release(); }
    explicit operator bool() const {
      return snapshot_ != nullptr;
    }  // false: nothing was published yet
    const Kept& operator*() const { return *snapshot_; }
    const Kept* operator->() const { return snapshot_; }

   private:
    friend class Board;
    Read(const Kept* snapshot, std::atomic<std::uint32_t>* readers)
        : snapshot_(snapshot), readers_(readers) {}
    void release() {
      if (readers_) readers_->fetch_sub(1);
      readers_ = nullptr;
    }
    const Kept* snapshot_ = nullptr;
    std::atomic<std::uint32_t>* readers_ = nullptr;
  };

  Board() = default;
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;

  // Any thread.
  Read read() const {
    for (;;) {
      const std::uint32_t index = current_.load();
      if (index == kNone) return {};
      const Slot& slot = slots_[index];
      slot.readers.fetch_add(1);
      if (current_.load() == index) return Read(&slot.snapshot, &slot.readers);
      // The writer moved on in between and may be filling this slot: not looked at.
      slot.readers.fetch_sub(1);
    }
  }

  // One thread at a time. Frees the snapshot that the chosen slot held. False: readers hold every
  // other slot, nothing changed; try again with the next rebuild.
  [[nodiscard]] bool publish(Kept snapshot) {
    const std::uint32_t current = current_.load();
    for (std::uint32_t step = 1; step <= kSlots; ++step) {
      // The slot after the current one was left longest ago, so its readers are the likeliest to
      // be gone.
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

  // Grows with every publication: a reader that remembers it knows whether there is something new.
  // Any thread.
  std::uint64_t generation() const { return generation_.load(); }

 private:
  struct alignas(64) Slot {
    Kept snapshot;
    mutable std::atomic<std::uint32_t> readers{0};
  };
  static constexpr std::uint32_t kNone = kSlots;
  std::array<Slot, kSlots> slots_;
  alignas(64) std::atomic<std::uint32_t> current_{kNone};
  std::atomic<std::uint64_t> generation_{0};
};

using SnapshotBoard = Board<Snapshot>;

}  // namespace driftwise::compensation
