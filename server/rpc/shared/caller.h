#pragma once
// Who calls, as the guard found it (server/guard.h), and what a client says of itself.

#include <grpcpp/server_context.h>

#include <string>
#include <string_view>

#include "server/access/identity.h"
#include "server/application/ports/caller.h"

namespace driftwise::rpc {

// The name of the identity; the peer (access/peer_name.h, "ipv4:127.0.0.1:5020"; of a call that
// came through the web gateway, the browser's), followed by how the identity was proved where it
// was: "ipv4:10.0.0.2:4711 (token k3f9a2c1)".
application::Caller caller_of(const grpc::CallbackServerContext& context);

// The identity behind the call.
const access::Identity& identity_of(const grpc::CallbackServerContext& context);

// Metadata "driftwise-operator" (ASCII) or "driftwise-operator-bin" (any UTF-8): at most 64 bytes,
// cleaned (core/clean_text.h); empty: neither is there.
std::string stated_name(const grpc::ServerContextBase& context);
// The peer as above, without the proof.
std::string peer_of(const grpc::ServerContextBase& context);
// Not over a socket: only the web gateway is inside the process.
bool from_inside(const grpc::ServerContextBase& context);
// The value of a key; empty: it is not there.
std::string_view metadata_value(const grpc::ServerContextBase& context, const char* key);

}  // namespace driftwise::rpc
