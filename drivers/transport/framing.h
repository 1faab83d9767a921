#pragma once
// Where a reply ends in the bytes received so far. Pure: no I/O.

#include <cstddef>
#include <string_view>

namespace driftwise::transport {

inline constexpr std::size_t kIncomplete = std::string_view::npos;

// Returns the length of the first complete reply in `bytes`, its end marks included, or
// kIncomplete. Carriage returns and line feeds in front of a reply belong to the one before and are
// counted in.
using Framing = std::size_t (*)(std::string_view bytes);

// One line, ended by CR, LF or any run of them; empty lines do not count.
std::size_t line_reply(std::string_view bytes);

// GCS 2.0: lines ended by LF; a line that ends with a space before its LF is followed by another.
std::size_t gcs_reply(std::string_view bytes);

// Without the CRs and LFs around it.
std::string_view without_line_ends(std::string_view reply);

}  // namespace driftwise::transport
