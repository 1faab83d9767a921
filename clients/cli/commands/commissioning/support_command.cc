#include <memory>

#include "clients/cli/commands/commissioning/commissioning_commands.h"
#include "driftwise/v1/record_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

ExitCode bundle(const Session& session, const std::string& file) {
  std::string bytes;
  session.connect().follow(&v1::RecordService::Stub::GetSupportBundle,
                           v1::GetSupportBundleRequest{},
                           [&bytes](const v1::GetSupportBundleResponse& piece) {
                             bytes += piece.data();
                             return true;
                           });
  write_output_file(file, bytes);
  if (session.console.json)
    session.console.print_json({{"file", file}, {"bytes", bytes.size()}});
  else
    session.console.out << "wrote " << file << ", " << bytes.size()
                        << " bytes: look at it before you hand it on\n";
  return ExitCode::done;
}

}  // namespace

void add_support_command(CLI::App& app, Session& session) {
  CLI::App& support = *app.add_subcommand("support", "Help from outside")->require_subcommand(1);
  auto file = std::make_shared<std::string>("driftwise-support.tar.gz");
  CLI::App& command =
      add_command(support, session, "bundle",
                  "Versions, device state, last events and log, schema, cell file; without secrets",
                  [&session, file] { return bundle(session, *file); });
  command.add_option("-o,--output", *file, "a .tar.gz")->capture_default_str();
}

}  // namespace driftwise::cli
