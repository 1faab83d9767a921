#pragma once
// What a verified client certificate says of its holder.

#include <openssl/types.h>

#include <optional>
#include <string>
#include <vector>

namespace driftwise::tls {

struct PeerCertificate {
  std::string name;               // common name of the subject, UTF-8
  std::vector<std::string> uris;  // of the subject's alternative names, in their order
  std::string pem = {};           // the whole certificate
};

// After the handshake. Nothing: the client showed none. One that the authority did not sign has
// ended the handshake before.
std::optional<PeerCertificate> peer_certificate(SSL* connection);

}  // namespace driftwise::tls
