#include "clients/cli/worker_threads.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace driftwise::cli {

int default_threads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

calibration::Executor worker_threads(int threads) {
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
      std::vector<std::jthread> helpers(std::min(count, static_cast<std::size_t>(threads)) -
                                        (count > 0 ? 1 : 0));
      for (auto& helper : helpers) helper = std::jthread(work);
      work();
    }
    if (problem) std::rethrow_exception(problem);
  };
}

}  // namespace driftwise::cli
