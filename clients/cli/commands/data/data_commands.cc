#include "clients/cli/commands/data/data_commands.h"

#include <memory>
#include <sstream>

#include "clients/cli/commands/data/exported_csv.h"
#include "clients/cli/commands/data/join_command.h"
#include "clients/cli/commands/data/remark_commands.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "clients/cli/pages/import_page.h"
#include "clients/cli/pages/run_text.h"
#include "driftwise/v1/data_service.grpc.pb.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/import/mapping_file.h"

namespace driftwise::cli {
namespace {

using DataStub = v1::DataService::Stub;

struct DataArguments {
  std::vector<std::int64_t> runs;
  std::string file, name, mapping, output, request_id;
  bool dry_run = false;
  int rows = 5;  // shown by a dry run
  bool without_excluded = false;
};

ExitCode export_data(const Session& session, const DataArguments& a) {
  const std::string csv = exported_csv(session, a.runs, a.without_excluded);
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

// A file of another program, by its mapping.
formats::ImportedDataset understand(const DataArguments& a) {
  const std::string bytes = read_input_file(a.file);
  const auto mapping =
      value_or_throw(formats::read_import_mapping(read_input_file(a.mapping), a.mapping));
  return value_or_throw(formats::import_dataset(bytes, a.file, mapping));
}

ExitCode show_import(const Console& console, const DataArguments& a) {
  const auto imported = understand(a);
  const auto rows = static_cast<std::size_t>(a.rows);
  if (console.json) {
    auto json = json_from(imported.report);
    std::ostringstream head;
    print_first_rows(head, imported.dataset, rows);
    json["first_rows_csv"] = head.str();
    console.print_json(json);
  } else {
    print_import(console.out, console.paint_out(), imported.report);
    console.out << '\n';
    print_first_rows(console.out, imported.dataset, rows);
  }
  return ExitCode::done;
}

ExitCode import_to_file(const Console& console, const DataArguments& a) {
  const auto imported = understand(a);
  const std::string csv = formats::write_dataset_csv(imported.dataset);
  if (a.output == "-") {
    console.out << csv << std::flush;
    return ExitCode::done;
  }
  write_output_file(a.output, csv, {a.file, a.mapping});
  if (console.json) {
    auto json = json_from(imported.report);
    json["file"] = a.output;
    json["bytes"] = csv.size();
    console.print_json(json);
  } else {
    print_import(console.err, console.paint_err(), imported.report);
    console.err << "wrote " << a.output << ", " << csv.size() << " bytes\n";
  }
  return ExitCode::done;
}

ExitCode import_data(const Session& session, const DataArguments& a) {
  if (a.mapping.empty() && (a.dry_run || !a.output.empty()))
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string(a.dry_run ? "--dry-run" : "-o") +
                      " shows what a mapping makes of a file: give --mapping MAP.toml too"};
  if (a.dry_run) return show_import(session.console, a);
  if (!a.output.empty()) return import_to_file(session.console, a);
  v1::ImportDatasetRequest request;
  request.set_csv(a.mapping.empty() ? read_input_file(a.file)
                                    : formats::write_dataset_csv(understand(a).dataset));
  request.set_name(a.name.empty() ? base_name(a.file) : a.name);
  request.set_request_id(a.request_id);
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
  out.add_flag("--without-excluded", a->without_excluded,
               "leave rows kept out of fits out, instead of marking them in a column");
  CLI::App& in = add_command(data, session, "import",
                             "A dataset CSV, or another program's file, as a run that is done",
                             [&session, a] { return import_data(session, *a); });
  in.add_option("FILE", a->file,
                "dataset CSV, - for standard input; with --mapping any table, also .gz")
      ->required();
  in.add_option("--mapping", a->mapping,
                "what the columns of another program's file mean: docs/import.md");
  in.add_option(
      "-o,--output", a->output,
      "with --mapping: write the dataset CSV here, no daemon needed; - for standard output");
  in.add_flag("--dry-run", a->dry_run,
              "with --mapping: show what was understood and the first rows, change nothing");
  in.add_option("--rows", a->rows, "rows that a dry run shows")->check(number_between(1, 1000));
  in.add_option("--name", a->name, "of the run; else the file's");
  in.add_option("--request-id", a->request_id,
                "the same id again answers with the run of the first time");
  add_join_command(data, session);
  add_instruments_command(data, session);
  add_angle_drift_command(data, session);
  add_exclusion_commands(data, session);
}

}  // namespace driftwise::cli
