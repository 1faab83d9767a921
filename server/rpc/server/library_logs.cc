#include "server/rpc/server/library_logs.h"

#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <spdlog/spdlog.h>

#include <mutex>
#include <string_view>

#include "server/access/failed_handshakes.h"

namespace driftwise::rpc {
namespace {

struct TlsDoor {
  std::mutex mutex;
  std::string newest = "an unknown client";
  access::FailedHandshakes failed{"gRPC door"};
};

// Never destroyed: gRPC's threads may outlive main().
TlsDoor& tls_door() {
  static auto& door = *new TlsDoor;
  return door;
}

// "Handshake failed with fatal error SSL_ERROR_SSL: error:0A000086:SSL routines::certificate verify
// failed."
void tell_failed_handshake(std::string_view message) {
  constexpr std::string_view kBefore = "SSL routines::";
  const auto cut = message.rfind(kBefore);
  if (cut != std::string_view::npos) message.remove_prefix(cut + kBefore.size());
  if (message.ends_with('.')) message.remove_suffix(1);
  auto& door = tls_door();
  std::string newest;
  {
    const std::lock_guard lock(door.mutex);
    newest = door.newest;
  }
  const auto line =
      door.failed.note(newest, std::string(message), std::chrono::steady_clock::now());
  if (line) spdlog::warn("{}", *line);
}

void take_grpc_line(gpr_log_func_args* args) {
  const std::string_view message = args->message;
  if (message.starts_with("Handshake failed")) tell_failed_handshake(message);
  spdlog::debug("gRPC: {}", message);
}

}  // namespace

void take_over_library_logs() {
  static const bool done = [] {
    gpr_set_log_function(take_grpc_line);
    google::protobuf::SetLogHandler(
        [](google::protobuf::LogLevel, const char*, int, const std::string& message) {
          spdlog::debug("protobuf: {}", message);
        });
    return true;
  }();
  static_cast<void>(done);
}

void note_tls_client(const std::string& host) {
  auto& door = tls_door();
  const std::lock_guard lock(door.mutex);
  door.newest = host;
}

}  // namespace driftwise::rpc
