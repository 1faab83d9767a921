#pragma once
// Revoked client certificates: the revocation list (CRL, RFC 5280) of the authority, from a PEM
// file, read anew when it changes. It is asked at every call, so that a certificate is out of force
// for connections that are open as well, on every door alike.
//
// Any thread.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <unordered_map>
#include <unordered_set>

#include "server/core/result.h"

namespace driftwise::access {

class RevokedCertificates {
 public:
  // Errors: not_found NO_FILE; invalid_argument BAD_CERTIFICATE (no list in PEM form, or one that
  // the authority did not sign), each with the path.
  static Result<std::unique_ptr<RevokedCertificates>> open(const std::string& path,
                                                           const std::string& authority);
  RevokedCertificates(const RevokedCertificates&) = delete;
  RevokedCertificates& operator=(const RevokedCertificates&) = delete;
  ~RevokedCertificates();

  // The certificate, in PEM form, is on the list; true for a text that is no certificate. Answered
  // from memory: a thread of its own looks at the file once a second, for a folder on a server that
  // is gone does not answer. One that cannot be read any more changes nothing: the last good list
  // holds.
  bool contains(const std::string& certificate_pem);

  // For the alarms: the list as it is on disk now. Errors: those of open();
  // failed_precondition CERTIFICATE_EXPIRED (its time for the next update has passed).
  static Result<void> check(const std::string& path, const std::string& authority,
                            std::int64_t now_utc_s);

 private:
  static constexpr std::chrono::seconds kLook{1};
  static constexpr std::size_t kMostKnown = 256;
  struct Stamp {
    std::int64_t modified_ns = -1;
    std::uint64_t inode = 0, bytes = 0;
    bool operator==(const Stamp&) const = default;
  };
  RevokedCertificates(std::string path, std::string authority)
      : path_(std::move(path)), authority_(std::move(authority)) {}
  Stamp stamp() const;
  void look();
  void look_again_and_again(const std::stop_token& ended);

  std::string path_, authority_;
  std::mutex mutex_;
  std::unordered_set<std::string> revoked_;             // issuer and serial number
  std::unordered_map<std::string, std::string> known_;  // of a PEM text; a bounded number
  Stamp read_;                                          // the thread's
  std::mutex sleeping_;
  std::condition_variable_any woken_;
  std::jthread thread_;  // last: it ends first
};

}  // namespace driftwise::access
