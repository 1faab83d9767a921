#pragma once
// One call of libcurl, which speaks HTTP and SMTP. TLS is verified, redirects are not followed,
// proxies of the environment are not used, what the other side says is kept up to 4 kB.

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "server/core/ports/outside/notifier.h"
#include "server/core/result.h"

namespace driftwise::notify {

struct HttpPost {
  std::string url, body, bearer, ca_file;  // bearer empty: none; ca_file empty: the system's
};

struct MailCall {
  std::string url, from, user, password, ca_file, message;
  std::vector<std::string> to;
  bool tls = true;  // by STARTTLS where the URL is smtp://; without it nothing is sent
};

// stop: looked at ten times a second. Result: "HTTP 200" with the first line of the answer.
// Errors: unavailable NOT_DELIVERED (no connection, no answer within the limit, a status other than
// 2xx), cancelled SHUTTING_DOWN.
Result<std::string> post(const HttpPost& call, std::chrono::milliseconds limit,
                         const std::atomic<bool>& stop);
// Result: the server's last line, "250 OK", and each recipient that it refused: the others have
// the mail. Errors besides: NOT_DELIVERED also where it refuses all of them,
// failed_precondition where it does so for good (5xx).
Result<Delivery> send_mail(const MailCall& call, std::chrono::milliseconds limit,
                           const std::atomic<bool>& stop);

}  // namespace driftwise::notify
