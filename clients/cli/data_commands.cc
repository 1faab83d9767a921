#include "clients/cli/data_commands.h"

#include <memory>

#include "clients/cli/proto_json.h"
#include "clients/cli/run_text.h"
#include "clients/cli/validators.h"
#include "driftwise/v1/data_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using DataStub = v1::DataService::Stub;

struct DataArguments {
  std::vector<std::int64_t> runs;
  std::string file, name;
};

ExitCode export_data(const Session& session, const DataArguments& a) {
  v1::ExportDatasetRequest request;
  for (const std::int64_t run : a.runs) request.add_run_ids(run);
  std::string csv;
  session.connect().follow(&DataStub::ExportDataset, request,
                           [&csv](const v1::ExportDatasetResponse& response) {
                             csv += response.chunk();
                             return true;
                           });
  if (a.file.empty() || a.file == "-") {
    session.console.out << csv << std::flush;
    return ExitCode::done;
  }
  write_output_file(a.file, csv);
  if (session.console.json)
    session.console.print_json({{"file", a.file}, {"bytes", csv.size()}});
  else
    session.console.err << "wrote " << a.file << ", " << csv.size() << " bytes\n";
  return ExitCode::done;
}

ExitCode import_data(const Session& session, const DataArguments& a) {
  v1::ImportDatasetRequest request;
  request.set_csv(read_input_file(a.file));
  request.set_name(a.name.empty() ? base_name(a.file) : a.name);
  const auto run = session.connect().ask(&DataStub::ImportDataset, request, 120).run();
  if (session.console.json)
    session.console.print_json(json_from(run));
  else
    print_run(session.console, run);
  return ExitCode::done;
}

}  // namespace

void add_data_commands(CLI::App& app, Session& session) {
  CLI::App& data =
      *app.add_subcommand("data", "Datasets out of and into the record")->require_subcommand(1);
  auto a = std::make_shared<DataArguments>();
  CLI::App& out = add_command(data, session, "export", "The accepted points of runs as dataset CSV",
                              [&session, a] { return export_data(session, *a); });
  out.add_option("RUN", a->runs, "numbers of the runs")->required()->check(positive_number());
  out.add_option("-o,--output", a->file, "write this file instead of standard output");
  CLI::App& in = add_command(data, session, "import", "A dataset CSV as a run that is done",
                             [&session, a] { return import_data(session, *a); });
  in.add_option("FILE", a->file, "dataset CSV, - for standard input")->required();
  in.add_option("--name", a->name, "of the run; else the file's");
}

}  // namespace driftwise::cli
