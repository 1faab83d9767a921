#include "server/access/identity.h"

namespace driftwise::access {

std::string_view to_string(Proof proof) {
  switch (proof) {
    case Proof::open_loopback:
      return "open loopback";
    case Proof::local_socket:
      return "local socket";
    case Proof::certificate:
      return "certificate";
    case Proof::token:
      return "token";
    case Proof::page_session:
      return "page session";
    case Proof::address:
      return "address";
  }
  return "none";
}

std::string sentence(const Identity& who) {
  std::string out = who.name + " (" + std::string(to_string(who.proof));
  if (!who.credential.empty()) out += " " + who.credential;
  return out + ", " + std::string(to_string(who.role)) + ", from " + who.from + ")";
}

}  // namespace driftwise::access
