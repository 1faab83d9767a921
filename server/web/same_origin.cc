#include "server/web/same_origin.h"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <string>
#include <utility>

#include "server/core/text/clean_text.h"
#include "server/web/security_headers.h"
#include "server/web/stop_socket.h"

namespace driftwise::web {
namespace {

bool is_port_or_nothing(std::string_view text) {
  return text.empty() ||
         (text[0] == ':' && text.size() >= 2 && text.size() <= 6 &&
          std::all_of(text.begin() + 1, text.end(), [](char c) { return c >= '0' && c <= '9'; }));
}

// "Cell.Lab.example:8443" -> "cell.lab.example"; nothing: no host with or without a port.
std::optional<std::string> name_of(std::string_view host_header) {
  const std::string host = lower(host_header);
  const std::size_t name_end = host.starts_with('[') ? host.find(']') + 1 : host.find(':');
  const std::string name = host.substr(0, name_end);
  if (name.empty() || (name_end < host.size() && !is_port_or_nothing(host.substr(name_end))))
    return std::nullopt;
  return name;
}

std::string shown(std::string_view text) {  // of a header: foreign bytes, for one line of text
  return "'" + clean_line(text.substr(0, 100)) + "'";
}

}  // namespace

bool is_loopback_host(std::string_view host_header) {
  const auto name = name_of(host_header);
  if (!name) return false;
  if (*name == "localhost" || *name == "[::1]") return true;
  boost::system::error_code bad;
  const auto address = boost::asio::ip::make_address_v4(*name, bad);
  return !bad && address.is_loopback();
}

bool is_own_host(const HttpRequest& request, const std::vector<std::string>& names) {
  const std::string_view host = request.header("host");
  if (is_loopback_host(host)) return true;
  const auto name = name_of(host);
  if (!name) return false;
  const bool v6 = request.local.find(':') != std::string::npos;
  if (*name == (v6 ? "[" + request.local + "]" : request.local)) return true;
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& one) { return lower(one) == *name; });
}

bool is_command(const HttpRequest& request) {
  return (request.method != "GET" && request.method != "HEAD") || asks_for_socket(request);
}

std::optional<HttpResponse> refuse_foreign(const HttpRequest& request,
                                           const std::vector<std::string>& names) {
  const std::string_view host = request.header("host");
  if (host.empty()) return plain_answer(400, "the request has no Host header\n");
  // Only one of several would be looked at here, and another one by whoever stands before us.
  for (const auto& [name, title] : {std::pair{"host", "Host"}, std::pair{"origin", "Origin"},
                                    std::pair{"sec-fetch-site", "Sec-Fetch-Site"}})
    if (std::count_if(request.headers.begin(), request.headers.end(),
                      [name = name](const HttpHeader& header) { return header.name == name; }) > 1)
      return plain_answer(400, "the request has several " + std::string(title) + " headers\n");
  if (!is_own_host(request, names))
    return plain_answer(421, "Host: found " + shown(host) +
                                 ", expected localhost, 127.0.0.1, [::1], the address of this door "
                                 "or a name of [access] names (docs/access.md)\n");
  if (!is_command(request)) return std::nullopt;
  const std::string_view origin = request.header("origin"), site = request.header("sec-fetch-site");
  const std::string here = (request.secure ? "https://" : "http://") + lower(host);
  // A plain door may stand behind a proxy or a tunnel that speaks TLS to the browser.
  const bool behind_tls = !request.secure && lower(origin) == "https://" + lower(host);
  if (!origin.empty() && lower(origin) != here && !behind_tls)
    return plain_answer(403, "Origin: found " + shown(origin) + ", expected " + here +
                                 ": a page of another site may not command this cell\n");
  if (!site.empty() && site != "same-origin" && site != "none")
    return plain_answer(403, "Sec-Fetch-Site: found " + shown(site) +
                                 ": a page of another site may not command this cell\n");
  return std::nullopt;
}

}  // namespace driftwise::web
