#include "clients/cli/commands/manual/man_page.h"

#include "clients/cli/commands/manual/examples.h"

namespace driftwise::cli {
namespace {

// A backslash begins a request, a dot or quote at the beginning of a line is one, and a plain
// hyphen may be set as a dash: none of it may happen to a command that people copy.
std::string roff(const std::string& text) {
  std::string out;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\'')
      out += "\\(aq";
    else if (c == '`')
      out += "\\(ga";
    else if (c == '^')
      out += "\\(ha";
    else if (c == '~')
      out += "\\(ti";
    else
      out += c;
    line_begins = c == '\n';
  }
  return out;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string value_text(const OptionText& option) {
  if (option.choices.empty()) return italic(option.value);
  std::string text;
  for (const auto& choice : option.choices) text += (text.empty() ? "" : " | ") + bold(choice);
  return text;
}

std::string synopsis(const CommandText& command) {
  std::string text = ".B driftwise" + (command.path.empty() ? "" : " " + roff(command.path)) + "\n";
  if (!command.commands.empty()) text += italic("COMMAND") + "\n";
  if (!command.options.empty()) text += "[" + italic("OPTIONS") + "]\n";
  for (const auto& one : command.positionals)
    text += (one.required ? "" : "[") + italic(one.names.front()) + (one.repeatable ? "..." : "") +
            (one.required ? "\n" : "]\n");
  return text;
}

std::string entry(const OptionText& option) {
  std::string text = ".TP\n", names;
  for (const auto& name : option.names) names += (names.empty() ? "" : ", ") + bold(name);
  text += names;
  if (!option.value.empty()) text += " " + value_text(option) + (option.repeatable ? " ..." : "");
  text += "\n" + roff(option.about);
  if (option.required) text += " (required)";
  if (!option.fallback.empty()) text += " [" + roff(option.fallback) + "]";
  return text + "\n";
}

std::string options_of(const CommandText& command) {
  std::string text;
  for (const auto& option : command.options)
    if (option.names.front() != "--help") text += entry(option);
  return text;
}

std::string examples_text(const std::string& verb) {
  std::string text;
  for (const auto& example : examples_of(verb))
    text += ".PP\n" + roff(std::string(example.what)) + ":\n.PP\n.nf\n.RS\n" +
            roff(std::string(example.line)) + "\n.RE\n.fi\n";
  return text;
}

std::string heading(const std::string& title, const std::string& version) {
  std::string upper;
  for (const char c : title)
    upper += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return ".TH \"" + roff(upper) + "\" 1 \"\" \"Driftwise " + version + "\" \"Driftwise\"\n.nh\n";
}

constexpr const char* kExitStatus =
    ".SH EXIT STATUS\n"
    ".TP\n.B 0\ndone\n"
    ".TP\n.B 1\ndone, and the answer is negative\n"
    ".TP\n.B 2\nusage\n"
    ".TP\n.B 3\nbad input\n"
    ".TP\n.B 4\nthe daemon or a device cannot be reached, or time is up\n"
    ".TP\n.B 5\nrefused or failed: state, lease, limits, an aborted run\n"
    ".TP\n.B 130\ninterrupted\n";

constexpr const char* kEnvironment =
    ".SH ENVIRONMENT\n"
    ".TP\n.B DRIFTWISE_SERVER\nhost:port of the daemon, where \\-\\-server is not given\n"
    ".TP\n.B DRIFTWISE_TLS_CA, DRIFTWISE_TLS_CERT, DRIFTWISE_TLS_KEY, DRIFTWISE_TOKEN_FILE\n"
    "as the options of these names\n"
    ".TP\n.B NO_COLOR\nno colour, not on a terminal either\n"
    ".SH FILES\n"
    ".TP\n.I driftwised.json\nin the working folder: the address of the daemon that keeps it "
    "there\n";

std::string program_page(const CommandText& program, const std::string& version) {
  std::string text = heading("driftwise", version);
  text += ".SH NAME\ndriftwise \\- the command line of a Driftwise cell\n.SH SYNOPSIS\n" +
          synopsis(program) +
          ".SH DESCRIPTION\nDriftwise keeps an ultra\\-high\\-precision robot accurate while the "
          "room, the "
          "process force and the robot itself drift. This program talks to the daemon\n.B "
          "driftwised\nof a cell; fits and diagnoses of a file need none.\n.SH COMMANDS\n";
  for (const auto& command : program.commands)
    text += ".TP\n" + bold("driftwise-" + command.name) + "(1)\n" + roff(command.about) + "\n";
  text += ".SH OPTIONS\nThey may stand anywhere on the line.\n" + options_of(program);
  return text + kExitStatus + kEnvironment;
}

std::string verb_page(const CommandText& verb, const std::string& version) {
  std::string text = heading("driftwise-" + verb.name, version) + ".SH NAME\ndriftwise\\-" +
                     roff(verb.name) + " \\- " + roff(verb.about) + "\n.SH SYNOPSIS\n";
  each_command(verb, [&](const CommandText& command) {
    if (command.commands.empty()) text += synopsis(command) + ".br\n";
  });
  if (!verb.commands.empty()) text += ".SH COMMANDS\n";
  each_command(verb, [&](const CommandText& command) {
    if (!command.commands.empty()) return;
    if (&command != &verb)
      text += ".SS " + roff(command.path) + "\n" + roff(command.about) + ".\n";
    else if (!command.positionals.empty() || command.options.size() > 1)
      text += ".SH OPTIONS\n";
    for (const auto& one : command.positionals) text += entry(one);
    text += options_of(command);
  });
  std::string examples;
  each_command(verb, [&](const CommandText& command) { examples += examples_text(command.path); });
  if (!examples.empty()) text += ".SH EXAMPLES\n" + examples;
  return text + kExitStatus + ".SH SEE ALSO\n.BR driftwise (1)\n";
}

}  // namespace

std::string man_page(const CommandText& program, const std::string& verb,
                     const std::string& version) {
  if (verb.empty()) return program_page(program, version);
  for (const auto& command : program.commands)
    if (command.name == verb) return verb_page(command, version);
  return {};
}

std::map<std::string, std::string> man_pages(const CommandText& program,
                                             const std::string& version) {
  std::map<std::string, std::string> pages{{"driftwise.1", program_page(program, version)}};
  for (const auto& command : program.commands)
    pages["driftwise-" + command.name + ".1"] = verb_page(command, version);
  return pages;
}

}  // namespace driftwise::cli
