#pragma once
// What every answer says to the browser, whatever it is about.

#include <string>

#include "server/web/http_message.h"

namespace driftwise::web {

// Adds: the content security policy (nothing but our own files, no inline script, no frame around
// us), no guessing of types, no address of ours to others, nothing of ours read by other sites.
void add_security_headers(HttpResponse& response);

// Text for a person at a terminal: UTF-8, never cached, with the headers above.
HttpResponse plain_answer(int status, std::string text);

}  // namespace driftwise::web
