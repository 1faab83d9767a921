// driftwise: the command line. Everything is in cli.h; here only what belongs to a process.

#include <poll.h>
#include <pwd.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <iostream>

#include "clients/cli/cli.h"

extern char** environ;

namespace {

// `driftwise events | head`: whoever stops reading has what he wanted.
bool reader_left() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return poll(&out, 1, 0) == 1 && (out.revents & (POLLERR | POLLHUP)) != 0;
}

// Until a line was typed; false at Ctrl-C, which a blocked read would not see: signals have a
// thread of their own.
bool await_answer(const driftwise::cli::Interrupt& interrupt) {
  constexpr int kLookAgain_ms = 50;
  pollfd in{STDIN_FILENO, POLLIN, 0};
  while (!interrupt.raised())
    if (poll(&in, 1, kLookAgain_ms) != 0) return true;
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace driftwise::cli;
  std::signal(SIGPIPE,
              SIG_IGN);  // `driftwise events | head` ends at the next write, not by a signal
  Interrupt interrupt;   // before any other thread
  Console console{std::cout,
                  std::cerr,
                  isatty(STDOUT_FILENO) != 0,
                  isatty(STDERR_FILENO) != 0,
                  80,
                  {},
                  ".",
                  false,
                  24,
                  &std::cin,
                  isatty(STDIN_FILENO) != 0,
                  [&interrupt] { return await_answer(interrupt); }};
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20) {
    console.err_width = size.ws_col;
    if (size.ws_row > 4) console.err_height = size.ws_row;
  }
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (const auto equals = text.find('='); equals != std::string::npos)
      console.environment[text.substr(0, equals)] = text.substr(equals + 1);
  }
  if (console.variable("USER").empty())  // cron and containers set none
    if (const passwd* user = getpwuid(geteuid()); user != nullptr)
      console.environment["USER"] = user->pw_name;
  const int exit = run_cli({argv + 1, argv + argc}, console, &interrupt);
  std::cout.flush();
  if (std::cout.good() || reader_left()) return exit;
  std::cerr << "driftwise: standard output could not be written whole: is its disk full?\n";
  return static_cast<int>(ExitCode::refused);
}
