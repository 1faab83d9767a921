#pragma once
// A child process for tests: started, listened to, ended by its pid. Never left behind: the
// destructor kills it.

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace driftwise::tests {

class Process {
 public:
  // arguments[0] is the program's path. environment: "NAME=value", added to ours. Standard output
  // is ours to read, standard error goes to the file (appended), or where ours goes when it is
  // empty. Throws std::runtime_error when it cannot be started.
  explicit Process(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment = {},
                   const std::string& stderr_file = {});
  Process(Process&& other) noexcept;
  Process& operator=(Process&& other) noexcept;
  ~Process();  // SIGKILL when it still runs

  pid_t pid() const { return pid_; }
  // The next line of its output without '\n'; nothing when it ended or the time ran out.
  std::optional<std::string> read_line(std::chrono::milliseconds limit);
  std::string read_to_end(std::chrono::milliseconds limit);
  void signal(int number) const;
  bool running();
  // Exit code, or 128 + signal; nothing when it still runs after the limit.
  std::optional<int> wait(std::chrono::milliseconds limit);

 private:
  void kill_and_reap();
  pid_t pid_ = -1;
  int out_ = -1;
  std::string buffer_;
  std::optional<int> ended_;
};

struct Finished {
  int code = -1;
  std::string out, err;
};
// Runs to the end, for at most the limit (then it is killed and code is -1).
Finished run_process(const std::vector<std::string>& arguments,
                     std::chrono::milliseconds limit = std::chrono::seconds(60),
                     const std::vector<std::string>& environment = {});

// A folder of its own under the system's temporary folder, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

// Both throw std::runtime_error.
std::string read_file(const std::string& path);
void write_file(const std::string& path, const std::string& text);

}  // namespace driftwise::tests
