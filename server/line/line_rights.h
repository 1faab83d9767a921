#pragma once
// What one client of the text line may ask, by what it is known. Thread: the executor's; only
// identity_of() is for a thread that may wait.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "server/access/access.h"
#include "server/tls/peer_certificate.h"

namespace driftwise::line {

enum class LineKind : std::uint8_t {
  loopback,       // plain; a token where [access] loopback = "token"
  tls,            // a client certificate, or a token
  plain_network,  // plain on a named interface: for listed addresses, targets only
};

class LineRights {
 public:
  // from: "ipv4:127.0.0.1:5020". access outlives it.
  LineRights(access::Access& access, LineKind kind, std::string from);

  // After the handshake of a TLS client. Errors: unauthenticated NO_ROLE, CERTIFICATE_REVOKED,
  // CERTIFICATE_EXPIRED.
  Result<void> take(const std::optional<tls::PeerCertificate>& certificate);
  // After identity_of(evidence_of(token)).
  void take(access::Identity who);

  const std::string& from() const { return from_; }
  bool known() const { return identity_.has_value(); }
  const access::Identity& identity() const { return *identity_; }
  access::Evidence evidence_of(const std::string& token) const;
  // A target is asked for. Errors: unauthenticated NO_IDENTITY (nobody yet, or its token or
  // certificate was revoked or has ended, by a look at most a second old); permission_denied
  // NEEDS_ROLE.
  Result<void> may_ask();

 private:
  access::Access& access_;
  LineKind kind_;
  std::string from_;
  std::optional<access::Identity> identity_;
  std::chrono::steady_clock::time_point checked_;
};

}  // namespace driftwise::line
