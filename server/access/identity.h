#pragma once
// Who is asking, and by what that is known. Plain data; any thread.

#include <cstdint>
#include <string>
#include <string_view>

#include "server/access/role.h"

namespace driftwise::access {

enum class Proof : std::uint8_t {
  open_loopback,  // none: a program on this computer, [access] loopback = "open"
  local_socket,   // the kernel named the user behind the unix socket
  certificate,    // client certificate of the authority, with a role
  token,
  page_session,  // logged in on the page, by a token or by a link that works once
  address,       // none but its address: the plain text line with its list of addresses
};

struct Identity {
  std::string name;                    // "ada"; cleaned, at most 64 bytes
  Role role = Role::viewer;            // the highest it has
  Proof proof = Proof::open_loopback;  //
  std::string credential;              // token's id, certificate's name; empty: none
  std::string from;                    // "ipv4:10.0.0.2:4711", "unix:0"
  // The client certificate whole, as PEM; empty: none was shown. A page session keeps that of the
  // link it was begun with. Not among the bytes that the web gateway vouches with.
  std::string certificate_pem = {};

  bool operator==(const Identity&) const = default;
};

// "open loopback", "local socket", "certificate", "token", "page session", "address".
std::string_view to_string(Proof proof);

// "ada (token k3f9, viewer, from ipv4:10.0.0.2:4711)": for messages and the record.
std::string sentence(const Identity& who);

}  // namespace driftwise::access
