// driftwise: the command line. Everything is in cli.h; here only what belongs to a process.

#include <pwd.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <iostream>

#include "clients/cli/cli.h"

extern char** environ;

int main(int argc, char** argv) {
  using namespace driftwise::cli;
  std::signal(SIGPIPE,
              SIG_IGN);  // `driftwise events | head` ends at the next write, not by a signal
  Interrupt interrupt;   // before any other thread
  Console console{
      std::cout, std::cerr, isatty(STDOUT_FILENO) != 0, isatty(STDERR_FILENO) != 0, 80, {}, ".",
      false,     24};
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
  return run_cli({argv + 1, argv + argc}, console, &interrupt);
}
