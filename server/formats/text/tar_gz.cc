#include "server/formats/text/tar_gz.h"

#include <zlib.h>

#include <array>
#include <cstdio>
#include <cstring>

#include "server/core/reasons.h"

namespace driftwise::formats {
namespace {

constexpr std::size_t kBlock = 512, kMostName = 99;

// Fields and their places: POSIX.1-1988, ustar.
void add_member(std::string& tar, const ArchiveMember& member, std::int64_t utc_s) {
  std::array<char, kBlock> header{};
  std::memcpy(header.data(), member.name.data(), member.name.size());
  std::snprintf(&header[100], 8, "%07o", 0600U);
  std::snprintf(&header[108], 8, "%07o", 0U);
  std::snprintf(&header[116], 8, "%07o", 0U);
  std::snprintf(&header[124], 12, "%011llo", static_cast<unsigned long long>(member.text.size()));
  std::snprintf(&header[136], 12, "%011llo", static_cast<unsigned long long>(utc_s));
  std::memset(&header[148], ' ', 8);  // the checksum counts itself as blanks
  header[156] = '0';
  std::memcpy(&header[257], "ustar", 6);
  std::memcpy(&header[263], "00", 2);
  unsigned sum = 0;
  for (const char byte : header) sum += static_cast<unsigned char>(byte);
  std::snprintf(&header[148], 8, "%06o", sum);
  header[155] = ' ';
  tar.append(header.data(), kBlock);
  tar += member.text;
  if (const std::size_t over = member.text.size() % kBlock; over > 0) tar.append(kBlock - over, 0);
}

}  // namespace

Result<std::string> tar_gz(const std::vector<ArchiveMember>& members, std::int64_t utc_s) {
  std::string tar;
  for (const auto& member : members) {
    if (member.name.empty() || member.name.size() > kMostName)
      return fail(ErrorCode::invalid_argument, reasons::kTooLong,
                  "a member of an archive is named '" + member.name + "', expected 1 to 99 bytes");
    add_member(tar, member, utc_s);
  }
  tar.append(2 * kBlock, 0);
  z_stream stream{};
  constexpr int kGzip = 15 + 16, kMemory = 8;  // window bits with a gzip header; the default
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, kMemory,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    return fail(ErrorCode::internal, reasons::kAllDropped, "zlib cannot begin to compress");
  std::string out(deflateBound(&stream, static_cast<uLong>(tar.size())), 0);
  stream.next_in = reinterpret_cast<Bytef*>(tar.data());
  stream.avail_in = static_cast<uInt>(tar.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int code = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  if (code != Z_STREAM_END)
    return fail(ErrorCode::internal, reasons::kAllDropped, "zlib did not compress everything");
  return out;
}

}  // namespace driftwise::formats
