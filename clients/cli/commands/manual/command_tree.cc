#include "clients/cli/commands/manual/command_tree.h"

#include <algorithm>
#include <array>
#include <sstream>

#include "clients/cli/commands/manual/examples.h"

namespace driftwise::cli {
namespace {

// "TEXT:{p,bic,aic}" -> p, bic, aic: how CLI11 writes a set of values.
std::vector<std::string> choices_in(const std::string& type) {
  const auto open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos || close < open) return {};
  std::istringstream inside(type.substr(open + 1, close - open - 1));
  std::vector<std::string> choices;
  for (std::string one; std::getline(inside, one, ',');) choices.push_back(one);
  return choices;
}

bool takes_file(const CLI::Option& option) {
  static constexpr auto kOptions = std::to_array<std::string_view>(
      {"--output", "--residuals", "--kinematics", "--mapping", "--to-pose", "--validation",
       "--report", "--into", "--model-file"});
  if (option.get_positional()) return option.get_name().find("FILE") != std::string::npos;
  return std::any_of(kOptions.begin(), kOptions.end(),
                     [&](std::string_view name) { return option.check_name(std::string(name)); });
}

OptionText describe(const CLI::Option& option) {
  OptionText text;
  if (option.get_positional()) {
    text.names = {option.get_name(true)};
  } else {
    for (const auto& name : option.get_lnames()) text.names.push_back("--" + name);
    for (const auto& name : option.get_snames()) text.names.push_back("-" + name);
  }
  text.about = option.get_description();
  if (option.get_items_expected_max() > 0) {
    const std::string type = option.get_type_name();
    text.choices = choices_in(type);
    text.value = type.substr(0, type.find(':'));
    if (text.value.empty()) text.value = "VALUE";
  }
  text.fallback = option.get_default_str();
  text.required = option.get_required();
  text.repeatable = option.get_items_expected_max() > 1;
  text.takes_file = takes_file(option);
  return text;
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* one) { return !one->get_name().empty(); });
}

CommandText describe(const CLI::App& app, const std::string& path) {
  CommandText text{app.get_name(), path, app.get_description(), {}, {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    (option->get_positional() ? text.positionals : text.options).push_back(describe(*option));
  }
  for (const CLI::App* below : commands_of(app))
    text.commands.push_back(
        describe(*below, path.empty() ? below->get_name() : path + " " + below->get_name()));
  return text;
}

void add_examples(CLI::App& app, const std::string& path, const std::string& exit_codes) {
  for (CLI::App* below :
       app.get_subcommands([](CLI::App* one) { return !one->get_name().empty(); })) {
    const std::string verb = path.empty() ? below->get_name() : path + " " + below->get_name();
    std::string footer;
    for (const auto& example : examples_of(verb))
      footer += "  " + std::string(example.line) + "\n      " + std::string(example.what) + "\n";
    below->footer((footer.empty() ? "" : "Examples:\n" + footer + "\n") + exit_codes);
    add_examples(*below, verb, exit_codes);
  }
}

}  // namespace

CommandText describe(const CLI::App& app) { return describe(app, ""); }

void add_examples(CLI::App& app, const std::string& exit_codes) {
  app.footer(exit_codes);
  add_examples(app, "", exit_codes);
}

}  // namespace driftwise::cli
