#pragma once
// Client certificate that this program shows: what speaks against it, before and after a daemon
// refused the connection. The daemon's refusal reaches a gRPC client as a closed connection only.

#include <cstdint>
#include <string>

#include "server/core/result.h"

namespace driftwise::tls {

// Errors: invalid_argument KEY_MISMATCH: the key is not the certificate's, or one of the two is
// none.
Result<void> check_pair(const std::string& certificate_pem, const std::string& key_pem);

// A sentence for each: it has ended, it is not good yet, another authority than this one signed it.
// Empty: nothing speaks against it.
std::string doubts_of(const std::string& certificate_pem, const std::string& authority_pem,
                      std::int64_t now_utc_s);

}  // namespace driftwise::tls
