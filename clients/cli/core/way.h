#pragma once
// The way to the daemon: its address, and what says who asks. docs/access.md.

#include <string>

#include "clients/cli/core/console.h"

namespace driftwise::cli {

// As the options say it; empty: not given.
struct WayOptions {
  std::string server, tls_ca, tls_cert, tls_key, token_file;
};

struct Way {
  std::string address;  // "127.0.0.1:50051", "unix:/path/driftwised.sock"
  std::string authority_pem, certificate_pem, key_pem;  // TLS with the first; the others are ours
  std::string token;                                    // "dwt_..."; empty: none
  // Folder of the driftwised.json that names this address: the cell's own. Empty: which cell it is
  // is not known here.
  std::string cell_folder;

  bool tls() const { return !authority_pem.empty(); }
};

// Option, else environment (DRIFTWISE_SERVER, _TLS_CA, _TLS_CERT, _TLS_KEY, _TOKEN_FILE), else
// driftwised.json in the working folder: its "socket" where this user may use it, else its "grpc"
// with the token of its "token_file" where this user may read it; else 127.0.0.1:50051. An address
// that is the "grpc" of driftwised.json gets that token too.
// Throws Failure: bad_input for a file that cannot be read or used, usage for an address without a
// port and for half a certificate.
Way find_way(const WayOptions& options, const Console& console);

}  // namespace driftwise::cli
