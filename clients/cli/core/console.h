#pragma once
// Where a command writes: data on out, progress and complaints on err. Tests hand in string
// streams.

#include <functional>
#include <istream>
#include <map>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

namespace driftwise::cli {

enum class ExitCode : int {
  done = 0,
  negative = 1,  // done, and the answer is no
  usage = 2,
  bad_input = 3,
  unreachable = 4,  // daemon or device
  refused = 5,      // or failed: state, limits, an aborted run
  interrupted = 130,
};

// Ends a command: what went wrong, for people and for programs. Thrown inside the client only,
// caught in run_cli.
struct Failure {
  ExitCode exit = ExitCode::refused;
  std::string code;     // "invalid_argument"
  std::string reason;   // "BAD_NUMBER"
  std::string message;  // with what to do
};

// Colour where it is wanted: a terminal, and neither NO_COLOR nor TERM=dumb.
class Paint {
 public:
  explicit Paint(bool on) : on_(on) {}
  std::string bold(const std::string& text) const { return wrap("1", text); }
  std::string dim(const std::string& text) const { return wrap("2", text); }
  std::string good(const std::string& text) const { return wrap("32", text); }
  std::string warn(const std::string& text) const { return wrap("33", text); }
  std::string bad(const std::string& text) const { return wrap("31", text); }

 private:
  std::string wrap(const char* code, const std::string& text) const {
    return on_ ? "\x1b[" + std::string(code) + "m" + text + "\x1b[0m" : text;
  }
  bool on_;
};

struct Console {
  std::ostream& out;
  std::ostream& err;
  bool out_is_terminal = false, err_is_terminal = false;
  int err_width = 80;                              // characters, for the progress bar
  std::map<std::string, std::string> environment;  // DRIFTWISE_SERVER, USER, NO_COLOR, TERM
  std::string working_folder = ".";
  bool json = false;           // --json
  int err_height = 24;         // lines, for a full screen
  std::istream* in = nullptr;  // where a question is answered; none: nobody can be asked
  bool in_is_terminal = false;
  // Waits until an answer can be read from in; false: the person interrupts instead. None: it is
  // there already.
  std::function<bool()> await_answer = {};

  std::string variable(const std::string& name) const {
    const auto found = environment.find(name);
    return found == environment.end() ? "" : found->second;
  }
  bool colour_wanted() const {
    return !environment.contains("NO_COLOR") && variable("TERM") != "dumb";
  }
  Paint paint_out() const { return Paint(out_is_terminal && colour_wanted()); }
  Paint paint_err() const { return Paint(err_is_terminal && colour_wanted()); }

  // One result for programs: one object, one line on a pipe, indented on a terminal. Bytes that are
  // not UTF-8, of a file's name or of its metadata, are replaced: JSON has no others.
  void print_json(const nlohmann::ordered_json& value) const {
    constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
    out << value.dump(out_is_terminal ? 2 : -1, ' ', false, kReplace) << '\n' << std::flush;
  }
};

}  // namespace driftwise::cli
