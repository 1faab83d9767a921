#pragma once
// How a fit's work is spread: the mathematics start no thread themselves.

#include <cstddef>
#include <functional>

namespace driftwise::calibration {

// Runs job(0) ... job(count - 1), in any order and on any threads, and returns when all are done.
// Empty: one after the other, here.
using Executor =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& job)>;

// With an executor or without.
inline void run_on(const Executor& executor, std::size_t count,
                   const std::function<void(std::size_t)>& job) {
  if (executor) return executor(count, job);
  for (std::size_t i = 0; i < count; ++i) job(i);
}

}  // namespace driftwise::calibration
