#pragma once
// Stop by a WebSocket: GET of StopAll's address with "Upgrade: websocket" (RFC 6455) is the call
// itself, and its answer is one message, the same bytes that the POST answers with.
//
// A browser opens six HTTP connections to one place for all its tabs, and a seventh request waits.
// A WebSocket does not count among them and is always a connection of its own, so neither slow
// calls nor a line that has died under the others keep a stop back. A browser can set no header of
// it: the operator's name stands in the query, as "?operator=" in base64url.
//
// The client sends nothing after its request. When it leaves, the stop is executed all the same.

#include <optional>
#include <string_view>

#include "server/web/http_message.h"

namespace driftwise::web {

inline constexpr std::string_view kStopPath = "/driftwise.v1.CellService/StopAll";

// A request of another page could be this one: it is judged as a command (same_origin.h).
bool asks_for_socket(const HttpRequest& head);

// What is wrong with a WebSocket's head: 404 another address than StopAll's, 400, 426.
std::optional<HttpResponse> refuse_socket(const HttpRequest& head);

// The call that the head stands for, as the POST of it would be.
HttpRequest call_of_socket(HttpRequest head);

// The answer of that call, from the handshake (101) to the frame that closes.
HttpResponse socket_answer(HttpResponse answer, std::string_view key);

}  // namespace driftwise::web
