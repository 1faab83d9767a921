#pragma once
// The TLS of one door: a context for each new connection, made of three PEM files.
//
// Renewal: the files are looked at (not read) at most once a second, when a connection begins. Sets
// that changed are read anew; connections that are open keep what they began with. A set that does
// not fit together, a half-copied one say, changes nothing: problem() has the sentence, and the
// last good set serves on.
//
// TLS 1.2 or newer, no renegotiation, no session tickets. Sources: RFC 8446, RFC 9325.
// Thread: one instance per door, on that door's thread.

#include <array>
#include <boost/asio/ssl/context.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "server/core/result.h"

namespace driftwise::tls {

// Paths of PEM files. authority: whose client certificates are taken; empty: none is asked for.
struct TlsFiles {
  std::string certificate, key, authority;
};

enum class ClientCertificate : std::uint8_t { ignored, accepted };  // accepted: optional, verified

class TlsMaterial {
 public:
  using Context = boost::asio::ssl::context;

  // protocol: the only one offered by ALPN ("http/1.1"); empty: none. Errors: failed_precondition
  // BAD_CERTIFICATE, naming the file that is missing, no PEM, or does not belong to the others.
  static Result<std::unique_ptr<TlsMaterial>> open(TlsFiles files, ClientCertificate clients,
                                                   std::string protocol = {});
  TlsMaterial(const TlsMaterial&) = delete;
  TlsMaterial& operator=(const TlsMaterial&) = delete;

  // For one connection; it keeps the context alive as long as it lasts.
  std::shared_ptr<Context> context();
  // Why the newest files do not serve; nothing: they do.
  const std::optional<std::string>& problem() const { return problem_; }

 private:
  // What tells one state of a file from another without reading it.
  struct Stamp {
    std::int64_t modified_ns = -1;
    std::uint64_t inode = 0, bytes = 0;
    bool operator==(const Stamp&) const = default;
  };
  using Stamps = std::array<Stamp, 3>;
  static constexpr std::chrono::seconds kLook{1};

  TlsMaterial(TlsFiles files, ClientCertificate clients, std::string protocol);
  Stamps stamps() const;
  Result<std::shared_ptr<Context>> read() const;

  TlsFiles files_;
  ClientCertificate clients_;
  std::string protocol_;
  Stamps read_stamps_, failed_stamps_;
  std::shared_ptr<Context> context_;
  std::optional<std::string> problem_;
  std::chrono::steady_clock::time_point looked_;
};

}  // namespace driftwise::tls
