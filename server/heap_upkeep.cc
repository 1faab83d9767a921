#include "server/heap_upkeep.h"

#include <malloc.h>

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace driftwise {
namespace {

constexpr auto kLookEvery = std::chrono::seconds(5);
constexpr Nanoseconds kEvery = std::chrono::minutes(10);

void keep_heap(const std::stop_token& ending, const std::function<CellTime()>& now) {
  std::mutex mutex;
  std::condition_variable_any woken;
  std::unique_lock lock(mutex);
  for (auto last = now(); !ending.stop_requested();) {
    woken.wait_for(lock, ending, kLookEvery, [] { return false; });
    if (ending.stop_requested() || now() - last < kEvery) continue;
    malloc_trim(0);
    last = now();
  }
}

}  // namespace

HeapUpkeep::HeapUpkeep(std::function<CellTime()> now)
    : thread_([now = std::move(now)](const std::stop_token& ending) { keep_heap(ending, now); }) {}

}  // namespace driftwise
