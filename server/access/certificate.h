#pragma once
// The daemon's certificate, as files: read for checks and warnings. TLS itself is the libraries'
// matter.

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/result.h"

namespace driftwise::access {

struct CertificateFacts {
  std::string subject, issuer;  // common names
  std::int64_t not_before_utc_s = 0, not_after_utc_s = 0;
  std::vector<std::string> names;  // DNS names and addresses it is good for
  std::vector<std::string> uris;
};

// The first certificate of a PEM file. Errors: not_found NO_FILE, invalid_argument BAD_CERTIFICATE,
// each with the path.
Result<CertificateFacts> read_certificate(const std::string& path);

// The same of a text. Errors: invalid_argument BAD_CERTIFICATE.
Result<CertificateFacts> certificate_from(const std::string& pem);

// The files of the daemon: both can be read, and the key is the certificate's. Its time is left
// out: that passes by itself and is no reason not to start. Errors: those above; invalid_argument
// BAD_KEY; failed_precondition KEY_MISMATCH, FILE_READABLE (others may read the key).
Result<CertificateFacts> check_files(const std::string& certificate, const std::string& key);

// The same, and the certificate is good now. Errors: those; failed_precondition
// CERTIFICATE_EXPIRED: its time is over or has not come.
Result<CertificateFacts> check_certificate(const std::string& certificate, const std::string& key,
                                           std::int64_t now_utc_s);

inline constexpr std::int64_t kExpiryWarningDays = 30;
// A sentence from 30 days before the end on; empty before that.
std::string expiry_warning(const std::string& path, const CertificateFacts& facts,
                           std::int64_t now_utc_s);

// "2027-11-29", of UTC.
std::string day_of(std::int64_t at_utc_s);

}  // namespace driftwise::access
