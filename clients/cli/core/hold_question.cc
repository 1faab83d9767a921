#include "clients/cli/core/hold_question.h"

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <vector>

#include "clients/cli/core/confirm.h"
#include "clients/cli/core/text.h"
#include "driftwise/v1/cell_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

std::string what_happened(const v1::Run& run, const google::protobuf::Timestamp& now) {
  const auto& hold = run.hold();
  const double age_s = static_cast<double>(now.seconds() - hold.begin_time().seconds());
  const std::string ago = span_text(age_s) + " ago";
  const std::string which = "run " + std::to_string(run.id());
  switch (hold.kind()) {
    case v1::RunHold::KIND_PAUSE:
      return which + " was paused by " + hold.who() + " " + ago;
    case v1::RunHold::KIND_STOP:
      return which + " was stopped by " + hold.who() + " " + ago;
    default:
      return which + " asks for a person since " + span_text(age_s) + ": " + hold.reason();
  }
}

}  // namespace

void add_hold_options(CLI::App& command, HoldOptions& options) {
  command.add_flag("--yes", options.yes,
                   "ask nothing: for scripts; somebody has looked at the machine");
  command.add_option("--override", options.override_reason,
                     "after another person's stop: why the robot may move, for the record");
}

v1::HoldAnswer answer_about(const Console& console, const v1::Run& run,
                            const google::protobuf::Timestamp& now, const HoldOptions& options,
                            const std::string& verb) {
  v1::HoldAnswer answer;
  answer.set_override_reason(options.override_reason);
  if (!run.has_hold()) return answer;
  std::vector<std::string> facts = {"the robot moves: look at the machine first"};
  if (run.hold().kind() == v1::RunHold::KIND_STOP)
    facts.push_back(run.hold().who() + " resumes it, or another one with --override REASON");
  facts.push_back("this question is no lock-out: others can move the robot too");
  confirm(console, options.yes, what_happened(run, now), facts, verb);
  answer.set_hold_id(run.hold().id());
  return answer;
}

v1::HoldAnswer answer_about_present_run(const Console& console, const Connection& connection,
                                        const HoldOptions& options, const std::string& verb) {
  const auto status = connection.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{});
  return answer_about(console, status.run().run(), status.cell_time(), options, verb);
}

}  // namespace driftwise::cli
