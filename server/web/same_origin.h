#pragma once
// Who may talk to a daemon on loopback: this computer's own pages and programs. A page of the
// internet can make a browser send requests here, by another name that resolves to 127.0.0.1 (DNS
// rebinding) or across sites; both are refused by what the browser itself says in its headers.

#include <optional>
#include <string_view>

#include "server/web/http_message.h"

namespace driftwise::web {

// "localhost", "127.0.0.1", "[::1]", each with or without a port. Through an ssh tunnel the port is
// another one, the name is not.
bool is_loopback_host(std::string_view host_header);

// Nothing: it may come in. Else 400 (no Host; Host, Origin or Sec-Fetch-Site twice), 421 (a foreign
// name), or for a POST 403 (Origin of another site, or Sec-Fetch-Site saying so). Programs that
// send no Origin are let in.
std::optional<HttpResponse> refuse_foreign(const HttpRequest& request);

}  // namespace driftwise::web
