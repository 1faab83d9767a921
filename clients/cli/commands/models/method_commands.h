#pragma once
// The predecessors' models beside ours, on a plain CSV file: `fit FILE.csv --method M` and `model
// compare FILE.csv`. docs/models.md.

#include <CLI/App.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "clients/cli/commands/models/fit_command.h"
#include "clients/cli/core/session.h"

namespace driftwise::cli {

struct MethodsOfFile {
  std::string kinematics;  // robot file or cell.toml
  std::string together;    // held out together: "line" or channels
  int folds = 10;
  std::vector<std::string> methods;  // empty: all that the given files allow
};

// --kinematics, --together and --folds.
void add_method_options(CLI::App& command, MethodsOfFile& methods);

// One method, as a page or driftwise.method.v1.
ExitCode fit_file_by_method(const Console& console, const FitOfFile& fit,
                            const MethodsOfFile& methods, std::string_view text,
                            const std::string& name);

// All asked for, side by side: a table or driftwise.comparison.v1. Of a file here, ...
ExitCode compare_methods(const Console& console, const FitOfFile& fit, const MethodsOfFile& methods,
                         std::string_view text, const std::string& name);
// ... of runs at the daemon, whose cell file has the geometry unless --kinematics gives another.
ExitCode compare_methods_of_runs(const Session& session, const FitOfFile& fit,
                                 const MethodsOfFile& methods,
                                 const std::vector<std::int64_t>& runs);

}  // namespace driftwise::cli
