#pragma once
// Who makes room at the HTTP door: a new client is always let in, because it may be the one that
// stops a motion, and the slowest of the present ones goes. Pure.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace driftwise::web {

using DoorInstant = std::chrono::steady_clock::time_point;

// In the order in which they make room.
enum class Activity : std::uint8_t {
  idle,       // between two requests
  receiving,  // a request that is not whole yet
  blocked,    // an answer that the client does not take
  waiting,    // a stream without news
  answering,  // a request at work
  stopping,   // a stop at work: never ended for another client
};

struct ConnectionState {
  std::string peer;  // its address, without the port
  Activity activity = Activity::idle;
  DoorInstant since;  // of the last byte that went either way
};

struct DoorQuotas {
  std::size_t in_all = 256;
  std::size_t per_peer = 224;  // programs of one computer are one peer
};

// Index of the connection that makes room for a newcomer of this peer; nothing: there is room.
// Beyond the peer's quota it is one of the peer's own, else one of the peer with the most. The
// slowest goes: the first activity of the list above, within it the one without a byte for longest.
// in_all when every candidate is a stop at work: the newcomer has to go.
std::optional<std::size_t> makes_room(std::span<const ConnectionState> present,
                                      const std::string& newcomer, const DoorQuotas& quotas);

}  // namespace driftwise::web
