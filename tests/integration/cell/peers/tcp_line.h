#pragma once
// A loopback TCP client for tests: asks, and reads what comes back. Throws std::runtime_error.

#include <chrono>
#include <string>

namespace driftwise::tests {

// One line out (without its '\n'), one line back.
std::string ask_line(const std::string& address, const std::string& line,
                     std::chrono::milliseconds limit = std::chrono::seconds(20));

// Sends the text and reads until the other side closes.
std::string ask_to_end(const std::string& address, const std::string& text,
                       std::chrono::milliseconds limit = std::chrono::seconds(20));

}  // namespace driftwise::tests
