#include "server/web/grpc_web_call.h"

#include <algorithm>
#include <charconv>
#include <cstdint>

#include "server/core/reasons.h"
#include "server/web/base64.h"

namespace driftwise::web {
namespace {

constexpr std::string_view kPackage = "/driftwise.v1.";
constexpr std::string_view kName = "driftwise-operator", kNameBytes = "driftwise-operator-bin",
                           kPeer = "driftwise-peer", kHeard = "driftwise-heard-ms";

bool is_word(std::string_view text) {
  return !text.empty() && text.size() <= 100 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

std::string printable(std::string_view text) {
  std::string out(text.substr(0, 256));
  for (char& c : out)
    if (c < 0x20 || c >= 0x7F) c = '?';
  return out;
}

constexpr std::int64_t kMostHours = 10'000;  // beyond it nanoseconds would overflow

// "500m": up to eight digits and a unit.
std::optional<std::chrono::nanoseconds> timeout_from(std::string_view text) {
  if (text.size() < 2 || text.size() > 9) return std::nullopt;
  std::int64_t count = 0;
  const char* end = text.data() + text.size() - 1;
  const auto [stop, bad] = std::from_chars(text.data(), end, count);
  if (bad != std::errc{} || stop != end || count < 0) return std::nullopt;
  switch (text.back()) {
    case 'H':
      return std::chrono::hours(std::min(count, kMostHours));
    case 'M':
      return std::chrono::minutes(std::min(count, kMostHours * 60));
    case 'S':
      return std::chrono::seconds(count);
    case 'm':
      return std::chrono::milliseconds(count);
    case 'u':
      return std::chrono::microseconds(count);
    case 'n':
      return std::chrono::nanoseconds(count);
    default:
      return std::nullopt;
  }
}

}  // namespace

bool is_method_path(std::string_view path) {
  if (!path.starts_with(kPackage)) return false;
  path.remove_prefix(kPackage.size());
  const std::size_t slash = path.find('/');
  return slash != std::string_view::npos && is_word(path.substr(0, slash)) &&
         is_word(path.substr(slash + 1));
}

Result<GrpcWebCall> grpc_web_call(const HttpRequest& request) {
  GrpcWebCall out;
  out.method = std::string(request.path());
  if (const auto text = request.header("grpc-timeout"); !text.empty()) {
    out.timeout = timeout_from(text);
    if (!out.timeout)
      return fail(ErrorCode::invalid_argument, reasons::kBadTimeout,
                  "grpc-timeout: found '" + printable(text) +
                      "', expected up to eight digits and one of H, M, S, m, u, n");
  }
  if (const auto name = request.header(kName); !name.empty())
    out.metadata.push_back({std::string(kName), printable(name)});
  if (const auto text = request.header(kNameBytes); !text.empty()) {
    auto bytes = base64_decode(text);
    if (!bytes)
      return fail(ErrorCode::invalid_argument, reasons::kBadMetadata,
                  std::string(kNameBytes) + ": expected base64");
    out.metadata.push_back({std::string(kNameBytes), bytes->substr(0, 256)});
  }
  if (const auto heard_ms = request.header(kHeard); !heard_ms.empty())
    out.metadata.push_back({std::string(kHeard), printable(heard_ms)});
  out.metadata.push_back({std::string(kPeer), printable(request.peer)});
  return out;
}

}  // namespace driftwise::web
