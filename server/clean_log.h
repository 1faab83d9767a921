#pragma once
// The log's lines: names and messages of others must not command the terminal that shows them, nor
// begin a line that looks like ours.

#include <spdlog/formatter.h>

#include <memory>
#include <string>

namespace driftwise {

// pattern as spdlog's, with the message cleaned to one line (core/clean_text.h).
std::unique_ptr<spdlog::formatter> clean_log_formatter(const std::string& pattern);

}  // namespace driftwise
