#pragma once
// Lines that gRPC and protobuf would write to the standard error stream. They go to the debug level
// of our log, but a TLS handshake that failed is a warning.

#include <string>

namespace driftwise::rpc {

// Once for the process; any thread.
void take_over_library_logs();

// gRPC does not say whose handshake failed: the client that came last to the door with TLS is named
// in its place. host: "ipv4:10.0.0.2".
void note_tls_client(const std::string& host);

}  // namespace driftwise::rpc
