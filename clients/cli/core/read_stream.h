#pragma once
// Reading of what is no regular file on a disk: a pipe, standard input, a device, /proc.

#include <cstddef>
#include <istream>
#include <string>

namespace driftwise::cli {

// Of what is read into memory; a larger table is given as a file, which is mapped.
constexpr std::size_t kMostReadBytes = std::size_t{1} << 30;

// All of the stream. It ends where the bytes are no text (UTF-16 is), so that a device without an
// end costs one block. Throws Failure (bad_input), naming the source: NOT_TEXT (zero bytes),
// TOO_LARGE, CANNOT_READ.
std::string read_stream(std::istream& stream, const std::string& name,
                        std::size_t most_bytes = kMostReadBytes);

}  // namespace driftwise::cli
