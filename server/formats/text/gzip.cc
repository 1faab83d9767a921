#include "server/formats/text/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <array>

#include "server/core/reasons.h"

namespace driftwise::formats {
namespace {

constexpr int kGzipOnly = 15 + 16;  // zlib: largest window, expect gzip's header and checksum

struct Inflating {
  z_stream stream{};
  bool open = false;
  Inflating() { open = inflateInit2(&stream, kGzipOnly) == Z_OK; }
  ~Inflating() {
    if (open) inflateEnd(&stream);
  }
  Inflating(const Inflating&) = delete;
  Inflating& operator=(const Inflating&) = delete;
};

tl::unexpected<Error> bad_gzip(Reason reason, const std::string& file_name,
                               const std::string& sentence) {
  return fail(ErrorCode::invalid_argument, reason, file_name + ": " + sentence);
}

}  // namespace

bool is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

Result<std::string> gunzip(std::string_view bytes, const std::string& file_name,
                           std::size_t most_bytes) {
  Inflating inflating;
  if (!inflating.open) return bad_gzip(reasons::kBadGzip, file_name, "zlib could not be started");
  z_stream& stream = inflating.stream;
  std::string out;
  std::array<char, 1 << 16> piece;
  std::size_t used = 0;
  for (int state = Z_OK; used < bytes.size() || state != Z_STREAM_END;) {
    if (state == Z_STREAM_END && inflateReset(&stream) != Z_OK)
      return bad_gzip(reasons::kBadGzip, file_name, "zlib could not go on to the next member");
    // zlib counts in 32 bits: a large file is handed over in pieces.
    const std::size_t take = std::min<std::size_t>(bytes.size() - used, 1U << 30);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + used));
    stream.avail_in = static_cast<uInt>(take);
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    state = inflate(&stream, Z_NO_FLUSH);
    used += take - stream.avail_in;
    out.append(piece.data(), piece.size() - stream.avail_out);
    if (out.size() > most_bytes)
      return bad_gzip(reasons::kTooLarge, file_name,
                      "found more than " + std::to_string(most_bytes >> 20) +
                          " MiB when inflated, expected less: split the file");
    const bool starved = used == bytes.size() && stream.avail_out == piece.size();
    if (state == Z_BUF_ERROR || (state == Z_OK && starved))
      return bad_gzip(reasons::kTruncatedGzip, file_name,
                      "the compressed file ends after " + std::to_string(used) +
                          " bytes in the middle of its data: copy it again");
    if (state != Z_OK && state != Z_STREAM_END)
      return bad_gzip(reasons::kBadGzip, file_name,
                      "the compressed data is damaged near byte " + std::to_string(used) +
                          ": copy the file again");
  }
  return out;
}

}  // namespace driftwise::formats
