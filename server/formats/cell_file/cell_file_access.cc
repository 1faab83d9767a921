#include "server/formats/cell_file/cell_file_access.h"

#include "server/formats/cell_file/cell_file_address.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

void check_tls_door(TomlReader& reader, const char* key, const std::string& address, bool tls) {
  if (address.empty()) return;
  if (!is_port(split_address(address).port, 0) || split_address(address).host.empty())
    return reader.refuse(key, reasons::kBadAddress,
                         "found " + shown(address) +
                             ", expected host:port such as 0.0.0.0:50052 (port 0: any free one)");
  if (!tls)
    reader.refuse(key, reasons::kNeedsTls,
                  "found " + shown(address) +
                      " without certificate and key: a door that others can reach needs TLS; "
                      "'driftwise cert init' makes the files");
}

}  // namespace

void read_access(TomlReader&& access, AccessDescription& out) {
  out.configured = true;
  std::string loopback = "token";
  access.choice("loopback", loopback, {"token", "open"}, Need::optional);
  out.loopback = loopback == "open" ? LoopbackRule::open : LoopbackRule::token;
  access.text("certificate", out.certificate);
  access.text("key", out.key);
  access.text("authority", out.authority);
  access.text("revoked", out.revoked);
  if (!out.revoked.empty() && out.authority.empty())
    access.refuse("revoked", reasons::kMissingKey,
                  "found a list of revoked certificates without authority, which signs the "
                  "certificates of clients and this list");
  access.text("listen", out.listen);
  access.text("http", out.http);
  access.text("target_line", out.target_line);
  const bool tls = !out.certificate.empty() && !out.key.empty();
  if (!tls && (!out.certificate.empty() || !out.key.empty()))
    access.refuse(out.key.empty() ? "certificate" : "key", reasons::kNeedsTls,
                  "found one of certificate and key, expected both: they belong together");
  check_tls_door(access, "listen", out.listen, tls);
  check_tls_door(access, "http", out.http, tls);
  check_tls_door(access, "target_line", out.target_line, tls);
  access.texts("names", out.names);
  access.number("session_h", out.session_h, {.min = 0.1, .max = 720});
  access.text("plain_target_line", out.plain_target_line);
  access.text("plain_interface", out.plain_interface);
  access.texts("plain_allow", out.plain_allow);
  check_tls_door(access, "plain_target_line", out.plain_target_line, true);
  if (!out.plain_target_line.empty() && (out.plain_interface.empty() || out.plain_allow.empty()))
    access.refuse("plain_target_line", reasons::kMissingKey,
                  "found a text line without TLS, expected beside it plain_interface, the network "
                  "interface it stands on, and plain_allow, the addresses that may ask there");
  access.finish();
}

}  // namespace driftwise::formats
