#include "drivers/transport/framing.h"

namespace driftwise::transport {
namespace {
constexpr std::string_view kLineEnds = "\r\n";
}

std::size_t line_reply(std::string_view bytes) {
  const std::size_t start = bytes.find_first_not_of(kLineEnds);
  if (start == std::string_view::npos) return kIncomplete;
  const std::size_t end = bytes.find_first_of(kLineEnds, start);
  return end == std::string_view::npos ? kIncomplete : end + 1;
}

std::size_t gcs_reply(std::string_view bytes) {
  const std::size_t start = bytes.find_first_not_of(kLineEnds);
  if (start == std::string_view::npos) return kIncomplete;
  for (std::size_t at = bytes.find('\n', start); at != std::string_view::npos;
       at = bytes.find('\n', at + 1)) {
    if (bytes[at - 1] != ' ') return at + 1;
  }
  return kIncomplete;
}

std::string_view without_line_ends(std::string_view reply) {
  const std::size_t first = reply.find_first_not_of(kLineEnds);
  if (first == std::string_view::npos) return {};
  return reply.substr(first, reply.find_last_not_of(kLineEnds) - first + 1);
}

}  // namespace driftwise::transport
