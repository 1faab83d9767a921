#include "tests/integration/cell/peers/tcp_line.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace driftwise::tests {
namespace {

[[noreturn]] void give_up(const std::string& address, const std::string& what) {
  throw std::runtime_error(address + ": " + what);
}

class Connection {
 public:
  explicit Connection(const std::string& address) : address_(address) {
    const auto colon = address.rfind(':');
    if (colon == std::string::npos) give_up(address, "expected host:port");
    sockaddr_in peer{};
    peer.sin_family = AF_INET;
    peer.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
    inet_pton(AF_INET, address.substr(0, colon).c_str(), &peer.sin_addr);
    fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(fd_, reinterpret_cast<sockaddr*>(&peer), sizeof peer) != 0) {
      const std::string why = std::strerror(errno);
      close(fd_);
      give_up(address, why);
    }
  }
  ~Connection() { close(fd_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void send_all(const std::string& text) const {
    if (send(fd_, text.data(), text.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(text.size()))
      give_up(address_, "cannot send");
  }

  // Until the line's end, or, without lines, until the other side closes.
  std::string receive(bool one_line, std::chrono::milliseconds limit) const {
    const auto until = std::chrono::steady_clock::now() + limit;
    std::string text;
    while (!one_line || !text.ends_with('\n')) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
          until - std::chrono::steady_clock::now());
      pollfd wait_for{fd_, POLLIN, 0};
      if (left.count() <= 0 || poll(&wait_for, 1, static_cast<int>(left.count())) <= 0)
        give_up(address_, "no answer in time, only '" + text + "'");
      char bytes[4096];
      const ssize_t count = recv(fd_, bytes, one_line ? 1 : sizeof bytes, 0);
      if (count <= 0) break;
      text.append(bytes, static_cast<std::size_t>(count));
    }
    return text;
  }

 private:
  std::string address_;
  int fd_ = -1;
};

}  // namespace

std::string ask_line(const std::string& address, const std::string& line,
                     std::chrono::milliseconds limit) {
  const Connection connection(address);
  connection.send_all(line + "\n");
  auto answer = connection.receive(true, limit);
  if (answer.ends_with('\n')) answer.pop_back();
  return answer;
}

std::string ask_to_end(const std::string& address, const std::string& text,
                       std::chrono::milliseconds limit) {
  const Connection connection(address);
  connection.send_all(text);
  return connection.receive(false, limit);
}

}  // namespace driftwise::tests
