#include <memory>

#include "clients/cli/commands/procedure/procedure_command.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/study_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

struct DesignArguments {
  std::int64_t model = 0;
  std::vector<std::string> changes;
  bool list = false;
};

void print_quantities(const Console& console, const v1::StudyDesignResponse& study) {
  Table table({{"name"}, {"now", Align::right}, {"what"}});
  for (const auto& one : study.quantities())
    table.add({one.name(), significant(one.value(), 6), one.what()});
  table.print(console.out, console.paint_out());
}

void print_lines(const Console& console, const v1::StudyDesignResponse& study) {
  for (const auto& place : study.places()) {
    std::vector<Table::Column> columns = {{place.name() + ": u, nm"}};
    std::vector<const v1::StudyDesignResponse::Output*> outputs;
    for (const auto& output : study.outputs())
      if (output.place() == place.name()) outputs.push_back(&output);
    if (outputs.empty()) continue;
    for (const auto* output : outputs) {
      const std::string symbol = output->channel().substr(0, output->channel().rfind('_'));
      columns.push_back({symbol + " today", Align::right});
      columns.push_back({"changed", Align::right});
    }
    Table table(columns);
    const auto row_of = [&](const std::string& title, auto before, auto after) {
      std::vector<Table::Cell> row{title};
      for (const auto* output : outputs) {
        row.push_back(before(*output));
        row.push_back(after(*output));
      }
      table.add(std::move(row));
    };
    using Output = v1::StudyDesignResponse::Output;
    for (int k = 0; k < outputs.front()->lines_size(); ++k)
      row_of(
          outputs.front()->lines(k).name(),
          [k](const Output& one) { return fixed(one.lines(k).u_before_nm(), 2); },
          [k](const Output& one) { return fixed(one.lines(k).u_after_nm(), 2); });
    row_of(
        "U90", [](const Output& one) { return fixed(one.u90_before_nm(), 2); },
        [](const Output& one) { return fixed(one.u90_after_nm(), 2); });
    row_of(
        "gain in U90", [](const Output&) { return std::string(); },
        [](const Output& one) {
          return signed_fixed(one.u90_before_nm() - one.u90_after_nm(), 2);
        });
    row_of(
        "largest line", [](const Output& one) { return one.largest_before(); },
        [](const Output& one) { return one.largest_after(); });
    if (outputs.front()->has_u90_uncompensated_before_nm())
      row_of(
          "U90, temperatures not compensated",
          [](const Output& one) { return fixed(one.u90_uncompensated_before_nm(), 2); },
          [](const Output& one) { return fixed(one.u90_uncompensated_after_nm(), 2); });
    console.out << '\n';
    table.print(console.out, console.paint_out());
  }
}

ExitCode study_design(const Session& session, const DesignArguments& a) {
  constexpr double kTakes_s = 120;
  if (a.changes.empty() && !a.list)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "what is changed? found no --change; --list shows what can be"};
  v1::StudyDesignRequest request;
  if (a.model != 0) request.set_model_id(a.model);
  for (const auto& change : a.changes) request.add_changes(change);
  const auto study = session.connect().ask(&v1::StudyService::Stub::StudyDesign, request, kTakes_s);
  const auto& console = session.console;
  if (console.json) {
    nlohmann::ordered_json json{{"schema", "driftwise.design.v1"}};
    json.update(json_from(study));
    console.print_json(json);
    return ExitCode::done;
  }
  if (a.list) print_quantities(console, study);
  if (a.changes.empty()) return ExitCode::done;
  console.out << "model " << study.model_id() << '\n';
  for (const auto& change : study.changes())
    console.out << "  " << change.what() << ": " << significant(change.before(), 6) << " -> "
                << significant(change.after(), 6) << '\n';
  print_lines(console, study);
  for (const auto& sentence : study.not_answered())
    console.out << "\nnot answered: " << sentence << '\n';
  return ExitCode::done;
}

}  // namespace

void add_design_command(CLI::App& app, Session& session) {
  auto a = std::make_shared<DesignArguments>();
  CLI::App& command = add_command(
      app, session, "design",
      "A design study: U90 with other instruments, lever arms or material, beside today's",
      [&session, a] { return study_design(session, *a); });
  command.add_option("--model", a->model, "whose targets; else the one that serves")
      ->check(positive_number());
  command
      .add_option("--change", a->changes,
                  "NAME=VALUE: x.u_length_nm=2, *.u_offset_mm=0.05, t04.expansion=0.1; repeatable")
      ->allow_extra_args(false);
  command.add_flag("--list", a->list, "what can be changed in this cell, with its present value");
}

}  // namespace driftwise::cli
