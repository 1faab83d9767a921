#pragma once
// The daemon's log: lines on standard error, the newest of them in memory for a support bundle.
// Names and messages of others must not command the terminal that shows them, nor begin a line that
// looks like ours.

#include <string>
#include <vector>

namespace driftwise {

// Of the whole process, once, before the first line. level: as of --log-level.
void set_up_log(const std::string& level);

// The newest lines, oldest first; any thread.
std::vector<std::string> log_tail();

}  // namespace driftwise
