#pragma once
// Which requests a browser may make here: those of this door's own page. A page of the internet can
// make a browser send requests by another name that resolves to us (DNS rebinding) or across sites;
// both are refused by what the browser itself says in its headers.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/web/http_message.h"

namespace driftwise::web {

// "localhost", "127.0.0.1", "[::1]", each with or without a port. Through an ssh tunnel the port is
// another one, the name is not.
bool is_loopback_host(std::string_view host_header);

// Names by which this door is called. Three kinds are: a loopback name; the address that the
// connection came to, which no name server can turn to another computer; and the configured names
// ("cell.lab.example"), without a port.
bool is_own_host(const HttpRequest& request, const std::vector<std::string>& names);

// It may change something: neither GET nor HEAD, or a WebSocket (stop_socket.h).
bool is_command(const HttpRequest& request);

// Nothing: it may come in. Else 400 (no Host; Host, Origin or Sec-Fetch-Site twice), 421 (a foreign
// name), or for a command 403 (Origin of another site, or Sec-Fetch-Site
// saying so). An Origin has the scheme of the connection: behind TLS a plain page is another site.
// Programs that send no Origin are let in: they have no cookie that a browser would lend them.
std::optional<HttpResponse> refuse_foreign(const HttpRequest& request,
                                           const std::vector<std::string>& names = {});

}  // namespace driftwise::web
