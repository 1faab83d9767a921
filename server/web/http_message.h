#pragma once
// One request and its answer, as the rest of the web room sees them: no socket, no parser.

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "server/core/ports/awaitable.h"

namespace driftwise::web {

// Header values whose case does not count: ASCII letters only.
inline std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

struct HttpHeader {
  std::string name, value;
};

struct HttpRequest {
  std::string method;               // "GET"
  std::string target;               // "/runs/17?tab=points", as it came
  std::vector<HttpHeader> headers;  // names in lower case, in the order they came
  std::string body;
  std::string peer;     // "ipv4:127.0.0.1:5020" (access/peer_name.h)
  std::string local;    // the address it came to, "127.0.0.1"
  bool secure = false;  // over TLS

  std::string_view path() const {  // the target without its query
    return std::string_view(target).substr(0, target.find('?'));
  }
  // The first header of this name (given in lower case); empty when there is none.
  std::string_view header(std::string_view name) const {
    for (const auto& one : headers)
      if (one.name == name) return one.value;
    return {};
  }
};

// A body that comes in pieces. The next piece is asked for when the last one has been written: a
// slow client slows whoever produces the pieces, and nobody else.
class BodyStream {
 public:
  struct Piece {
    std::string bytes;
    bool last = false;
  };
  virtual ~BodyStream() = default;
  virtual Awaitable<Piece> next() = 0;
  // The client went away: next(), if it waits, returns soon with whatever it likes.
  virtual void abandon() = 0;
};

struct HttpResponse {
  int status = 200;
  std::vector<HttpHeader> headers;
  std::string body;                    // or
  std::shared_ptr<BodyStream> stream;  // in chunks
};

// Who answers. Everything on the web thread.
class HttpSite {
 public:
  virtual ~HttpSite() = default;
  // Looks at the head, before the body is read: a refusal, or how many bytes of body may follow.
  // The head outlives the wait, which may be that for a token to be checked.
  using Admitted = std::variant<HttpResponse, std::size_t>;
  virtual Awaitable<Admitted> admit(const HttpRequest& head) = 0;
  virtual Awaitable<HttpResponse> answer(HttpRequest request) = 0;
};

}  // namespace driftwise::web
