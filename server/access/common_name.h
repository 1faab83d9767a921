#pragma once
// Common name of a certificate's subject or issuer, whichever of ASN.1's encodings it has.

#include <openssl/types.h>

#include <string>

namespace driftwise::access {

// The first one, UTF-8, one clean line. Empty: there is none, or its bytes are not in the encoding
// that they say.
std::string common_name(const X509_NAME* name);

}  // namespace driftwise::access
