#include "server/threads/threaded_executor.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace driftwise::threads {

int processors() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

calibration::Executor threaded_executor(int threads) {
  if (threads <= 1) return {};
  return [threads](std::size_t count, const std::function<void(std::size_t)>& job) {
    std::atomic<std::size_t> next = 0;
    std::mutex mutex;
    std::exception_ptr problem;
    const auto work = [&] {
      try {
        for (std::size_t i = next++; i < count; i = next++) job(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!problem) problem = std::current_exception();
      }
    };
    {
      const std::size_t helping =
          count < 2 ? 0 : std::min(count, static_cast<std::size_t>(threads)) - 1;
      std::vector<std::jthread> helpers(helping);
      for (auto& helper : helpers) helper = std::jthread(work);
      work();
    }
    if (problem) std::rethrow_exception(problem);
  };
}

}  // namespace driftwise::threads
