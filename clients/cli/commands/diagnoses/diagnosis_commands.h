#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "clients/cli/core/session.h"
#include "driftwise/v1/diagnosis_service.pb.h"

namespace driftwise::cli {

// diagnosis list, show, accept, undo, cancel, export: what the daemon found, and what is made of
// it.
void add_diagnosis_commands(CLI::App& app, Session& session);

// diagnose --run: in the daemon, with its progress; Ctrl-C cancels it there.
struct DiagnoseRunArguments {
  std::vector<std::int64_t> runs;
  std::int64_t model = 0;  // 0: none was named
  std::string baseline, name;
  double alpha = 0.003;
  std::uint64_t seed = 1;
  std::vector<std::string> without;
  std::string robot;  // "": of a cell with one, or the one that the baseline names
};
ExitCode diagnose_runs(const Session& session, const DiagnoseRunArguments& a);

// "thermal_lag t07"; of wrong rows, which are of no channel: "outliers".
std::string cause_of(const v1::Finding& finding);

// The page for people.
void print_diagnosis(const Console& console, const v1::Diagnosis& diagnosis);

}  // namespace driftwise::cli
