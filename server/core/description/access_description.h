#pragma once
// [access] of a cell file: who may reach the daemon, and by which doors. Plain data. Text form:
// docs/cell-file.md; what it means: docs/access.md.

#include <string>
#include <vector>

namespace driftwise {

// What a program on this computer may do through a TCP door on loopback without saying who it is.
enum class LoopbackRule {
  open,   // everything: as without [access]
  token,  // nothing: it shows a token, for example the one of the file in the state folder
};

struct AccessDescription {
  bool configured = false;  // the file has an [access] section
  LoopbackRule loopback = LoopbackRule::open;
  // PEM files, absolute. certificate: the daemon's own, followed by those between it and the root.
  // authority: who signs the certificates of clients; empty: clients show tokens only.
  std::string certificate, key, authority;
  std::string revoked;  // PEM file, absolute: certificates of clients that count no longer
  // Doors with TLS, host:port, also outside loopback; empty: none. They stand beside the plain
  // doors on loopback of [cell].
  std::string listen;       // gRPC
  std::string http;         // the page
  std::string target_line;  // the text line
  // The text line without TLS on a network of its own: for the addresses listed, targets only.
  std::string plain_target_line, plain_interface;
  std::vector<std::string> plain_allow;  // "192.168.7.10", "192.168.7.0/24"

  std::vector<std::string> names;  // by which browsers call the page, besides its address
  double session_h = 12;           // how long a log-in of the page lasts

  bool tls() const { return !certificate.empty(); }
};

}  // namespace driftwise
