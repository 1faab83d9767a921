#pragma once
// What every command needs: the options all of them share, and the way to the daemon.

#include <CLI/App.hpp>
#include <functional>
#include <string>

#include "clients/cli/core/connection.h"
#include "clients/cli/core/console.h"
#include "clients/cli/core/interrupt.h"

namespace driftwise::cli {

struct Session {
  Console& console;
  Interrupt* interrupt = nullptr;
  std::string server, operator_name;  // --server, --operator
  double timeout_s = 0;               // --timeout; 0: not given
  std::function<ExitCode()> action;   // set by the command that was named
  WayOptions way = {};                // --tls-ca, --tls-cert, --tls-key, --token-file

  // Throws Failure for files that cannot be used (way.h); the connection itself is made by the
  // first call.
  Connection connect() const {
    if (interrupt != nullptr) interrupt->attend();
    WayOptions options = way;
    options.server = server;
    return {find_way(options, console), operator_name, timeout_s, interrupt, &console.out};
  }
  // Connection::for_halting(); a way that cannot be used has halted nothing either.
  Connection connect_for_halting(const char* done) const {
    try {
      return connect().for_halting(done);
    } catch (const Failure& failure) {
      throw not_halted(done, failure);
    }
  }
};

// Adds a command whose action runs after all of the line was understood.
inline CLI::App& add_command(CLI::App& parent, Session& session, const std::string& name,
                             const std::string& what, std::function<ExitCode()> action) {
  CLI::App& command = *parent.add_subcommand(name, what);
  command.callback([&session, action = std::move(action)] { session.action = action; });
  return command;
}

// The whole of a text file, "-" for standard input. Throws Failure (bad_input) naming it.
std::string read_input_file(const std::string& path);
// The same path's last part: how a run is named when nobody named it.
std::string base_name(const std::string& path);
// Writes a file in one piece (a temporary beside it, then renamed), or nothing. A link stays a
// link, a device or pipe (/dev/null) is written to as it is, and so is what this process has open
// (/dev/stdout, /dev/fd/3, "-" for standard output), where it stands: `-o /dev/stdout >> file` adds
// to the file. Throws Failure (bad_input CANNOT_WRITE) naming it; what stood there before still
// does then. Of standard output main.cc says it at the end.
// Standard output is that of set_standard_output().
// read: files that the command read, which may be the only copy of a measurement; refused.
void write_output_file(const std::string& path, const std::string& text,
                       const std::vector<std::string>& read = {});
// "-", "/dev/stdout", "/dev/fd/1", or a link to one of them.
bool is_standard_output(const std::string& path);
// Stream that write_output_file() takes for standard output; std::cout at first. Returns the one
// before.
std::ostream& set_standard_output(std::ostream& stream);

}  // namespace driftwise::cli
