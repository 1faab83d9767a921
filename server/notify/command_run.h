#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "server/core/result.h"

namespace driftwise::notify {

// Runs a program in a process group of its own, without a shell, with `input` on its standard
// input. It and what it started end with it, or at the limit. Result: the last line that it
// printed, or "exit code 0". Errors: unavailable NOT_DELIVERED (it cannot be started, ends with
// another code than 0, takes longer than the limit), cancelled SHUTTING_DOWN. The caller's program
// ignores SIGPIPE.
Result<std::string> run_command(const std::vector<std::string>& command, const std::string& input,
                                std::chrono::milliseconds limit, const std::atomic<bool>& stop);

}  // namespace driftwise::notify
