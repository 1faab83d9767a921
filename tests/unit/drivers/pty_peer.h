#pragma once
// The other end of a serial line: a pseudo-terminal and a thread that answers what comes over it.

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <utility>

namespace driftwise::tests {

class PtyPeer {
 public:
  // answer: takes what it understands from the front of what has come, and gives the reply; on the
  // peer's own thread.
  explicit PtyPeer(std::function<std::string(std::string& received)> answer)
      : answer_(std::move(answer)), ours_(::posix_openpt(O_RDWR | O_NOCTTY)) {
    ::grantpt(ours_);
    ::unlockpt(ours_);
    path_ = ::ptsname(ours_);
    theirs_ = ::open(path_.c_str(), O_RDWR | O_NOCTTY);  // open as long as the peer lives
    termios raw{};
    ::tcgetattr(theirs_, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(theirs_, TCSANOW, &raw);
    thread_ = std::thread([this] { serve(); });
  }
  ~PtyPeer() {
    over_ = true;
    thread_.join();
    ::close(theirs_);
    ::close(ours_);
  }
  PtyPeer(const PtyPeer&) = delete;
  const std::string& path() const { return path_; }

 private:
  void serve() {
    std::string received;
    while (!over_) {
      pollfd waiting{ours_, POLLIN, 0};
      char bytes[256];
      if (::poll(&waiting, 1, 5) <= 0) continue;
      const auto count = ::read(ours_, bytes, sizeof bytes);
      if (count <= 0) continue;
      received.append(bytes, static_cast<std::size_t>(count));
      const std::string reply = answer_(received);
      if (reply.empty()) continue;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));  // as an instrument: never at once
      if (::write(ours_, reply.data(), reply.size()) < 0) return;
    }
  }

  std::function<std::string(std::string&)> answer_;
  int ours_, theirs_ = -1;
  std::string path_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

}  // namespace driftwise::tests
