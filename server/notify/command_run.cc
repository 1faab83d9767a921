#include "server/notify/command_run.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"

namespace driftwise::notify {
namespace {

constexpr std::size_t kMostPrinted = 4096;

class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void take(int number) {
    close();
    number_ = number;
  }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }
  int get() const { return number_; }

 private:
  int number_;
};

// A process group that ends with this object.
class Child {
 public:
  ~Child() { end(); }
  Child() = default;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  int start(const std::vector<std::string>& command, int in, int out) {
    std::vector<char*> arguments;
    for (const auto& one : command) arguments.push_back(const_cast<char*>(one.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, in, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&files, out, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, out, STDERR_FILENO);
    // Nothing else of the daemon: a command that outlives it would keep its ports and its links.
    posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(
        &attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    const int code = ::posix_spawnp(&id_, command.front().c_str(), &files, &attributes,
                                    arguments.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    if (code != 0) id_ = 0;
    return code;
  }

  bool has_ended() const {
    siginfo_t info{};
    return id_ == 0 ||
           (::waitid(P_PID, static_cast<id_t>(id_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
            info.si_pid == id_);
  }

  // Ends the group; the wait status of the program itself.
  int end() {
    if (id_ == 0) return 0;
    ::kill(-id_, SIGKILL);  // not reaped yet: the number is still its own
    int status = 0;
    while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = 0;
    return status;
  }

 private:
  pid_t id_ = 0;
};

std::string last_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  const auto cut = text.rfind('\n');
  return clean_line(cut == std::string::npos ? text : text.substr(cut + 1));
}

}  // namespace

Result<std::string> run_command(const std::vector<std::string>& command, const std::string& input,
                                std::chrono::milliseconds limit, const std::atomic<bool>& stop) {
  const std::string name = command.empty() ? "" : command.front();
  const auto bad = [&name](const std::string& why) {
    return fail(ErrorCode::unavailable, reasons::kNotDelivered,
                clean_line("command " + name + ": " + why));
  };
  std::array<int, 2> in{}, out{};
  if (name.empty()) return bad("it is empty");
  if (::pipe2(in.data(), O_CLOEXEC) != 0) return bad(std::strerror(errno));
  Descriptor child_in(in[0]), to_child(in[1]);
  if (::pipe2(out.data(), O_CLOEXEC) != 0) return bad(std::strerror(errno));
  Descriptor from_child(out[0]), child_out(out[1]);
  ::fcntl(to_child.get(), F_SETFL, O_NONBLOCK);
  ::fcntl(from_child.get(), F_SETFL, O_NONBLOCK);
  Child child;
  if (const int code = child.start(command, child_in.get(), child_out.get()); code != 0)
    return bad(std::string("it cannot be started: ") + std::strerror(code));
  child_in.close();
  child_out.close();

  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + limit;
  std::size_t sent = 0;
  std::string printed;
  bool over = false;
  for (bool ended = false; !ended && !stop.load();) {
    if (Clock::now() >= end) {
      over = true;
      break;
    }
    ended = child.has_ended();  // once more is read afterwards
    if (sent == input.size()) to_child.close();
    std::array<pollfd, 2> ends = {{{from_child.get(), POLLIN, 0}, {to_child.get(), POLLOUT, 0}}};
    if (!ended) ::poll(ends.data(), ends.size(), 20);
    if (to_child.get() >= 0 && ends[1].revents != 0) {
      const ssize_t written = ::write(to_child.get(), input.data() + sent, input.size() - sent);
      if (written > 0)
        sent += static_cast<std::size_t>(written);
      else if (errno != EAGAIN && errno != EINTR)
        to_child.close();  // it does not read its input
    }
    std::array<char, 1024> bytes{};
    ssize_t got = 0;
    while ((got = ::read(from_child.get(), bytes.data(), bytes.size())) > 0) {
      printed.append(bytes.data(), static_cast<std::size_t>(got));
      if (printed.size() > kMostPrinted) printed.erase(0, printed.size() - kMostPrinted);
      if (Clock::now() >= end) break;  // it prints for ever
    }
    if (got == 0) from_child.close();  // its output goes elsewhere: poll() would return at once
  }
  const int status = child.end();
  const std::string said = last_line(printed);
  if (stop.load())
    return fail(ErrorCode::cancelled, reasons::kShuttingDown,
                "command " + name + ": the program ends");
  if (over)
    return bad("it took longer than " + std::to_string(limit.count() / 1000) + " s and was ended");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return bad((WIFEXITED(status) ? "exit code " + std::to_string(WEXITSTATUS(status))
                                  : "ended by signal " + std::to_string(WTERMSIG(status))) +
               (said.empty() ? "" : ": " + said));
  return said.empty() ? "exit code 0" : said;
}

}  // namespace driftwise::notify
