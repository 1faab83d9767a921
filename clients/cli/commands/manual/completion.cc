#include "clients/cli/commands/manual/completion.h"

#include <functional>

namespace driftwise::cli {
namespace {

// 'it'\''s': one word for any of the shells' single quotes, as bash and zsh want it.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

// fish knows \' and \\ inside single quotes.
std::string quoted_for_fish(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

std::string joined(const std::vector<std::string>& words, const char* between = " ") {
  std::string out;
  for (const auto& word : words) out += (out.empty() ? "" : between) + word;
  return out;
}

std::string place(const CommandText& command) {
  return command.path.empty() ? "driftwise" : "driftwise " + command.path;
}

bool wants_file(const CommandText& command) {
  for (const auto& one : command.positionals)
    if (one.takes_file) return true;
  return false;
}

std::vector<std::string> positional_choices(const CommandText& command) {
  for (const auto& one : command.positionals)
    if (!one.choices.empty()) return one.choices;
  return {};
}

// "a"|"b"|"c": every place that a further word can lead to.
std::string places_below(const CommandText& program) {
  std::vector<std::string> places;
  each_command(program, [&](const CommandText& command) {
    if (!command.path.empty()) places.push_back(quoted(place(command)));
  });
  return joined(places, "|");
}

// The program's own options may stand after any command.
template <class Visit>
void each_option_at(const CommandText& program, const CommandText& command, Visit visit) {
  for (const auto& option : command.options) visit(option);
  if (&command != &program)
    for (const auto& option : program.options)
      if (option.names.front() != "--help" && option.names.front() != "--version") visit(option);
}

// The lines of a case over "place option" that answer what may follow: words, files, or anything.
std::string value_cases(const CommandText& program, const std::string& words_line_begin,
                        const std::string& words_line_end, const std::string& files_line) {
  std::string text;
  each_command(program, [&](const CommandText& command) {
    each_option_at(program, command, [&](const OptionText& option) {
      if (option.value.empty()) return;
      std::vector<std::string> patterns;
      for (const auto& name : option.names) patterns.push_back(quoted(place(command) + " " + name));
      std::string what = "return";
      if (!option.choices.empty())
        what = words_line_begin + joined(option.choices) + words_line_end + "; return";
      else if (option.takes_file)
        what = files_line + "; return";
      text += "    " + joined(patterns, "|") + ") " + what + " ;;\n";
    });
  });
  return text;
}

}  // namespace

std::string bash_completion(const CommandText& program) {
  std::string text =
      "# bash completion for driftwise; made by: driftwise completion bash\n"
      "_driftwise() {\n"
      "  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} at=driftwise i\n"
      "  local words='' options='' files=''\n"
      "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
      "    case \"$at ${COMP_WORDS[i]}\" in\n"
      "      " +
      places_below(program) +
      ") at=\"$at ${COMP_WORDS[i]}\" ;;\n"
      "    esac\n"
      "  done\n"
      "  case \"$at $prev\" in\n" +
      value_cases(program, "COMPREPLY=($(compgen -W '", "' -- \"$cur\"))",
                  "compopt -o filenames; COMPREPLY=($(compgen -f -- \"$cur\"))") +
      "  esac\n"
      "  case \"$at\" in\n";
  each_command(program, [&](const CommandText& command) {
    std::vector<std::string> words = positional_choices(command), options;
    for (const auto& below : command.commands) words.push_back(below.name);
    each_option_at(program, command, [&](const OptionText& option) {
      options.insert(options.end(), option.names.begin(), option.names.end());
    });
    text += "    " + quoted(place(command)) + ") words=" + quoted(joined(words)) +
            " options=" + quoted(joined(options)) + (wants_file(command) ? " files=1" : "") +
            " ;;\n";
  });
  text +=
      "  esac\n"
      "  if [[ $cur == -* ]]; then\n"
      "    COMPREPLY=($(compgen -W \"$options\" -- \"$cur\"))\n"
      "  elif [[ -n $files ]]; then\n"
      "    compopt -o filenames; COMPREPLY=($(compgen -f -- \"$cur\"))\n"
      "  else\n"
      "    COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n"
      "  fi\n"
      "}\n"
      "complete -F _driftwise driftwise\n";
  return text;
}

std::string zsh_completion(const CommandText& program) {
  // `path` is zsh's own: the place is called `at`.
  std::string text =
      "#compdef driftwise\n"
      "# zsh completion for driftwise; made by: driftwise completion zsh\n"
      "_driftwise() {\n"
      "  local at=driftwise i files\n"
      "  local -a commands options\n"
      "  for ((i = 2; i < CURRENT; i++)); do\n"
      "    case \"$at ${words[i]}\" in\n"
      "      " +
      places_below(program) +
      ") at=\"$at ${words[i]}\" ;;\n"
      "    esac\n"
      "  done\n"
      "  case \"$at ${words[CURRENT-1]}\" in\n" +
      value_cases(program, "compadd -- ", "", "_files") +
      "  esac\n"
      "  case \"$at\" in\n";
  // In a list of _describe a colon parts the word from what it is.
  const auto entry = [](const std::string& word, const std::string& about) {
    std::string shown;
    for (const char c : about) shown += c == ':' ? std::string("\\:") : std::string(1, c);
    return " " + quoted(word + ":" + shown);
  };
  each_command(program, [&](const CommandText& command) {
    text += "    " + quoted(place(command)) + ")\n";
    if (!command.commands.empty() || !positional_choices(command).empty()) {
      text += "      commands=(";
      for (const auto& below : command.commands) text += entry(below.name, below.about);
      for (const auto& word : positional_choices(command)) text += entry(word, "");
      text += ")\n";
    }
    text += "      options=(";
    each_option_at(program, command, [&](const OptionText& option) {
      for (const auto& name : option.names) text += entry(name, option.about);
    });
    text += ")\n";
    if (wants_file(command)) text += "      files=1\n";
    text += "      ;;\n";
  });
  text +=
      "  esac\n"
      "  if [[ $PREFIX == -* ]]; then\n"
      "    _describe -o option options\n"
      "  elif [[ -n $files ]]; then\n"
      "    _files\n"
      "  elif (( $#commands )); then\n"
      "    _describe command commands\n"
      "  fi\n"
      "}\n"
      "if [[ $funcstack[1] == _driftwise ]]; then _driftwise \"$@\"; else compdef _driftwise "
      "driftwise; fi\n";
  return text;
}

std::string fish_completion(const CommandText& program) {
  std::vector<std::string> places;
  each_command(program, [&](const CommandText& command) {
    if (!command.path.empty()) places.push_back(quoted_for_fish(place(command)));
  });
  std::string text =
      "# fish completion for driftwise; made by: driftwise completion fish\n"
      "function __driftwise_at\n"
      "  set -l at driftwise\n"
      "  for word in (commandline -opc)[2..]\n"
      "    if contains -- \"$at $word\" " +
      joined(places) +
      "\n"
      "      set at \"$at $word\"\n"
      "    end\n"
      "  end\n"
      "  test \"$at\" = \"$argv[1]\"\n"
      "end\n"
      "complete -c driftwise -f\n";
  each_command(program, [&](const CommandText& command) {
    const std::string here =
        "complete -c driftwise -n " + quoted_for_fish("__driftwise_at '" + place(command) + "'");
    for (const auto& below : command.commands)
      text += here + " -a " + below.name + " -d " + quoted_for_fish(below.about) + "\n";
    if (const auto words = positional_choices(command); !words.empty())
      text += here + " -a " + quoted_for_fish(joined(words)) + "\n";
    if (wants_file(command)) text += here + " -F\n";
    each_option_at(program, command, [&](const OptionText& option) {
      text += here;
      for (const auto& name : option.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!option.value.empty()) text += option.takes_file ? " -r -F" : " -x";
      if (!option.choices.empty()) text += " -a " + quoted_for_fish(joined(option.choices));
      text += " -d " + quoted_for_fish(option.about) + "\n";
    });
  });
  return text;
}

}  // namespace driftwise::cli
