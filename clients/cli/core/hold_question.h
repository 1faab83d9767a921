#pragma once
// The question before a run that stands is resumed, or before the axes are moved meanwhile: who
// paused it, how long ago, and why.

#include <CLI/App.hpp>
#include <string>

#include "clients/cli/core/connection.h"
#include "clients/cli/core/console.h"
#include "driftwise/v1/run.pb.h"

namespace driftwise::cli {

struct HoldOptions {
  bool yes = false;             // --yes: nobody is asked
  std::string override_reason;  // --override: why another one than the one who stopped goes on
};

// Adds --yes and --override.
void add_hold_options(CLI::App& command, HoldOptions& options);

// Asks about what the run stands for and gives the answer that the daemon wants to be named; empty
// when it stands for nothing. verb: "Resume run 3". Throws Failure as confirm() does.
v1::HoldAnswer answer_about(const Console& console, const v1::Run& run,
                            const google::protobuf::Timestamp& now, const HoldOptions& options,
                            const std::string& verb);

// The same about the run under way, for a movement by hand.
v1::HoldAnswer answer_about_present_run(const Console& console, const Connection& connection,
                                        const HoldOptions& options, const std::string& verb);

}  // namespace driftwise::cli
