#pragma once
// Named places where a test may kill the daemon: docs/crash-points.md lists them. Always compiled
// in, never armed unless the environment says DRIFTWISE_CRASH_POINT=name[:n] when the process
// starts: the n-th passing (from 1) ends the process with SIGKILL, as a power cut would as far as
// the process is concerned.

#include <functional>
#include <string_view>

namespace driftwise::application {

// Executor's thread or writer's thread. Costs one relaxed load when nothing is armed.
void crash_point(std::string_view name);

// For tests that live in one process: called at every crash point instead of dying. Empty takes it
// away.
void on_crash_point(std::function<void(std::string_view)> hook);

}  // namespace driftwise::application
