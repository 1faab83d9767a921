#pragma once
// The one place that decides who somebody is and what they may do. Asked by gRPC, the web gateway
// and the text line. Any thread.

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/access_witness.h"
#include "server/access/identity.h"
#include "server/access/proof_ends.h"
#include "server/access/revoked_certificates.h"
#include "server/access/token_book.h"
#include "server/access/wrong_tries.h"
#include "server/core/description/access_description.h"
#include "server/core/result.h"

namespace driftwise::access {

enum class Door : std::uint8_t { unix_socket, loopback, tls };

// Client as a door knows it.
struct Evidence {
  Door door = Door::tls;
  std::string from = {};  // "ipv4:10.0.0.2:4711", "unix:"
  std::string stated_name =
      {};  // what the client calls itself; counts only where nobody proves anything
  std::string bearer = {};  // "dwt_...", without "Bearer "; empty: none
  // Of a client certificate that the TLS library has verified against the authority; empty: none.
  std::string certificate_name = {};
  std::vector<std::string> certificate_uris = {};
  std::string certificate_pem = {};  // the same certificate whole: a revoked one counts no longer
};

// Right that is asked for: its name in messages, and the role it needs.
struct Action {
  std::string_view name;
  Role needed = Role::admin;
};

class Authoriser {
 public:
  struct Parts {
    LoopbackRule loopback = LoopbackRule::open;
    TokenBook* tokens = nullptr;             // outlives this; nullptr: no tokens
    RevokedCertificates* revoked = nullptr;  // outlives this; nullptr: no list
    std::string local_token = {};            // of the file in the state folder: admin; empty: none
    std::string local_user = {};  // who runs the daemon; name of who uses its socket or local token
    // For tests; empty: the computer's clocks. utc_s: seconds of UTC, for the end of tokens.
    std::function<WrongTries::Instant()> steady = {};
    std::function<std::int64_t()> utc_s = {};
  };
  static constexpr int kMostToldPerMinute = 20;  // of one source; further ones are counted
  explicit Authoriser(Parts parts);

  // Who is told of refusals; nullptr: nobody. It outlives its last call; set it to nullptr before.
  void tell(AccessWitness* witness);
  // What the room's users have to tell: a token made or revoked.
  void note(AccessNote what);

  // Order: a bearer token (a wrong one is refused whatever else is known), a certificate with a
  // role, the unix socket, open loopback. May compute a scrypt (token_book.h). Errors:
  // unauthenticated NO_IDENTITY (what to do), BAD_TOKEN, NO_ROLE (a certificate without a role),
  // CERTIFICATE_REVOKED, CERTIFICATE_EXPIRED (it ended while its connection stands);
  // resource_exhausted TOO_MANY_TRIES (for how long).
  Result<Identity> identify(const Evidence& evidence);

  // What this identity was proved with is in force still: its token is in the book and has not
  // ended, its certificate is neither revoked nor over. True for a proof without an end: the unix
  // socket, the local token, open loopback. Every door asks it of whatever outlasts one call: a
  // certificate was verified when its connection began, and may have ended since.
  bool in_force(const Identity& who) const;

  // The token is known to be good without a scrypt: that of the state folder, or one that was
  // checked since the start.
  bool knows(std::string_view bearer) const;

  // Tokens and certificates that are about to end, or have just ended, each with its sentence; then
  // the others that are known, without one.
  std::vector<EndingProof> ending() const;

  // The identity may do this. Errors: permission_denied NEEDS_ROLE: who, what was asked, the role
  // it needs, the role there is.
  Result<void> authorise(const Identity& who, const Action& action);

  // For the web gateway, which is inside the process: the identity of a browser as bytes that only
  // this process makes and accepts. Metadata kVouchedKey of its calls.
  static constexpr const char* kVouchedKey = "driftwise-identity-bin";
  std::string vouch(const Identity& who) const;
  std::optional<Identity> vouched(std::string_view bytes) const;

 private:
  Result<Identity> by_token(const Evidence& evidence);
  Identity local(const Evidence& evidence, Proof proof) const;
  tl::unexpected<Error> wrong_token(const Evidence& evidence, const Error& error);
  tl::unexpected<Error> nobody(const Evidence& evidence);
  bool revoked(const std::string& certificate_pem) const {
    return parts_.revoked != nullptr && parts_.revoked->contains(certificate_pem);
  }
  tl::unexpected<Error> certificate_over(const Evidence& evidence);
  void note_within_bounds(AccessNote what);

  Parts parts_;
  ShownCertificates shown_;
  std::string secret_;            // of vouch(): made at the start
  std::string local_token_hash_;  // SHA-256
  std::mutex mutex_;              // of what follows
  AccessWitness* witness_ = nullptr;
  WrongTries tries_;
  struct Told {
    WrongTries::Instant since;
    std::int64_t told = 0, silent = 0;
  };
  std::map<std::string, Told> told_;  // by source, of this minute
};

}  // namespace driftwise::access
