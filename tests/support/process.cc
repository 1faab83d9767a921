#include "tests/support/process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>
#include <utility>

namespace driftwise::tests {

using Clock = std::chrono::steady_clock;

Process::Process(const std::vector<std::string>& arguments,
                 const std::vector<std::string>& environment, const std::string& stderr_file) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw std::runtime_error("pipe: " + std::string(std::strerror(errno)));
  std::vector<char*> argv;
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  std::vector<char*> env;
  for (char** entry = environ; *entry; ++entry) env.push_back(*entry);
  for (const auto& entry : environment) env.push_back(const_cast<char*>(entry.c_str()));
  env.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork: " + std::string(std::strerror(errno)));
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that dies takes its children with it
    dup2(ends[1], STDOUT_FILENO);
    if (!stderr_file.empty()) {
      const int file = open(stderr_file.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
      if (file >= 0) dup2(file, STDERR_FILENO);
    }
    execvpe(argv[0], argv.data(), env.data());
    _exit(127);
  }
  close(ends[1]);
  out_ = ends[0];
}

Process::Process(Process&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      out_(std::exchange(other.out_, -1)),
      buffer_(std::move(other.buffer_)),
      ended_(std::exchange(other.ended_, std::nullopt)) {}

Process& Process::operator=(Process&& other) noexcept {
  if (this != &other) {
    kill_and_reap();
    pid_ = std::exchange(other.pid_, -1);
    out_ = std::exchange(other.out_, -1);
    buffer_ = std::move(other.buffer_);
    ended_ = std::exchange(other.ended_, std::nullopt);
  }
  return *this;
}

Process::~Process() { kill_and_reap(); }

void Process::kill_and_reap() {
  if (pid_ > 0 && !ended_) {
    ::kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (out_ >= 0) close(out_);
  pid_ = -1;
  out_ = -1;
}

std::optional<std::string> Process::read_line(std::chrono::milliseconds limit) {
  const auto until = Clock::now() + limit;
  while (true) {
    const std::size_t end = buffer_.find('\n');
    if (end != std::string::npos) {
      std::string line = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      return line;
    }
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    if (left <= 0) return std::nullopt;
    pollfd wait_for{out_, POLLIN, 0};
    if (poll(&wait_for, 1, static_cast<int>(left)) <= 0) continue;
    char bytes[4096];
    const ssize_t count = read(out_, bytes, sizeof bytes);
    if (count <= 0) return std::nullopt;
    buffer_.append(bytes, static_cast<std::size_t>(count));
  }
}

std::string Process::read_to_end(std::chrono::milliseconds limit) {
  const auto until = Clock::now() + limit;
  while (true) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd wait_for{out_, POLLIN, 0};
    if (left <= 0 || poll(&wait_for, 1, static_cast<int>(left)) <= 0) break;
    char bytes[65536];
    const ssize_t count = read(out_, bytes, sizeof bytes);
    if (count <= 0) break;
    buffer_.append(bytes, static_cast<std::size_t>(count));
  }
  return std::exchange(buffer_, {});
}

void Process::signal(int number) const {
  if (pid_ > 0 && !ended_) ::kill(pid_, number);
}

bool Process::running() { return !wait(std::chrono::milliseconds(0)).has_value(); }

std::optional<int> Process::wait(std::chrono::milliseconds limit) {
  const auto until = Clock::now() + limit;
  while (!ended_) {
    int status = 0;
    const pid_t who = waitpid(pid_, &status, WNOHANG);
    if (who == pid_) ended_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (ended_ || Clock::now() >= until) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return ended_;
}

Finished run_process(const std::vector<std::string>& arguments, std::chrono::milliseconds limit,
                     const std::vector<std::string>& environment) {
  const auto until = Clock::now() + limit;
  const TemporaryFolder folder;
  const std::string complaints = folder.path() + "/stderr";
  Process process(arguments, environment, complaints);
  Finished finished;
  finished.out = process.read_to_end(limit);
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
  finished.code = process.wait(std::max(left, std::chrono::milliseconds(100))).value_or(-1);
  finished.err = read_file(complaints);
  return finished;
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "driftwise-XXXXXX").string();
  if (!mkdtemp(pattern.data()))
    throw std::runtime_error("mkdtemp " + pattern + ": " + std::strerror(errno));
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!(file << text).flush()) throw std::runtime_error("cannot write " + path);
}

}  // namespace driftwise::tests
