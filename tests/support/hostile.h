#pragma once
// A seeded grammar of what somebody may send to a door before any log-in: TLS records, HTTP
// requests, gRPC-Web frames, tokens, lines; valid pieces, valid pieces that are damaged, and noise.
// The same seed gives the same bytes.

#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace driftwise::tests {

class Hostile {
 public:
  explicit Hostile(std::uint64_t seed) : random_(seed) {}

  std::string tls();    // records: a ClientHello, its damage, other records, noise
  std::string http();   // one request or several, with hostile heads and bodies
  std::string line();   // of the text protocol, with its end, or several
  std::string token();  // "dwt_..." and what is none

  // From the whole message to a byte: with one bit turned, a piece doubled, lost or replaced.
  std::string damaged(std::string bytes);
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
  bool once_in(std::size_t times) { return below(times) == 0; }

 private:
  template <class T, std::size_t N>
  const T& one_of(const T (&list)[N]) {
    return list[below(N)];
  }
  std::string noise(std::size_t most);
  std::string frame();
  std::string header();
  std::string path();

  std::mt19937_64 random_;
};

// Sends the bytes over a new connection, says that nothing more follows, and returns all that comes
// back until the other side closes. Throws std::runtime_error when that takes longer than 20 s.
std::string answer_to(const std::string& address, std::string_view bytes);

// Bytes of memory that the process holds now.
std::size_t resident_bytes();

// DRIFTWISE_HOSTILE_REQUESTS, else `usual`.
int hostile_count(int usual);

}  // namespace driftwise::tests
