#include "server/rpc/shared/heard.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>

#include "driftwise/v1/access.pb.h"
#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"

namespace driftwise::rpc {
namespace {

std::int64_t limit_ms(std::string_view path) {
  std::string name(path.substr(1));
  std::replace(name.begin(), name.end(), '/', '.');
  const auto* method = google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(name);
  return method == nullptr ? 0 : method->options().GetExtension(v1::heard_within_ms);
}

}  // namespace

Result<void> heard_recently(std::string_view path, std::string_view heard_ms,
                            std::chrono::system_clock::time_point now) {
  const std::int64_t most_ms = limit_ms(path);
  if (most_ms == 0) return {};
  std::int64_t at_ms = 0;
  const char* end = heard_ms.data() + heard_ms.size();
  const auto [stop, bad] = std::from_chars(heard_ms.data(), end, at_ms);
  if (bad != std::errc{} || stop != end || at_ms < 0)
    return fail(ErrorCode::invalid_argument, reasons::kBadMetadata,
                fmt::format("{}: found '{}', expected Unix time in ms, server_time of the last "
                            "WatchResponse",
                            kHeardKey, clean_line(heard_ms.substr(0, 40))));
  const auto now_ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
  if (now_ms - at_ms <= most_ms) return {};
  return fail(
      ErrorCode::failed_precondition, reasons::kAskedLongAgo,
      fmt::format("{} was asked with a view of the cell that is {:.1f} s old, at most "
                  "{:.1f} s are allowed for what moves: nothing was done. Look at the "
                  "machine and ask again",
                  path.substr(path.rfind('/') + 1), static_cast<double>(now_ms - at_ms) / 1000,
                  static_cast<double>(most_ms) / 1000));
}

}  // namespace driftwise::rpc
