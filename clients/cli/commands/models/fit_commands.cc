#include "clients/cli/commands/models/fit_commands.h"

#include <memory>

#include "clients/cli/commands/models/kinematic_commands.h"
#include "clients/cli/commands/models/method_commands.h"
#include "clients/cli/core/input_text.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/model_service.grpc.pb.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/model_json.h"

namespace driftwise::cli {
namespace {

using ModelStub = v1::ModelService::Stub;

struct FitArguments {
  FitOfFile fit;
  MethodsOfFile methods;
  std::string method = "stepwise";
  bool joint_errors = false;
  std::string file, name, note;
  std::vector<std::int64_t> runs;
};

// Rows of a run are kept out for everybody, and on record; residuals are those of rows at hand.
void refuse_file_options(const FitOfFile& fit) {
  if (!fit.exclude_rows.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--exclude-rows works on a file only: driftwise data exclude RUN --rows ... "
                  "--reason ... keeps rows of a run out"};
  if (!fit.residuals.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--residuals works on a file only: driftwise data export RUN -o data.csv, then "
                  "driftwise fit data.csv"};
  if (!fit.output.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "-o works on a file only: the daemon keeps the model of a run, and driftwise "
                  "model export N -o FILE writes it"};
  if (!fit.validation.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--validation works on a file only: rows of a run are validation where its "
                  "trajectory says so"};
}

std::vector<effects::Term> terms_from(
    const google::protobuf::RepeatedPtrField<std::string>& texts) {
  std::vector<effects::Term> terms;
  for (const auto& text : texts)
    if (auto term = formats::parse_term(text)) terms.push_back(std::move(*term));
  return terms;
}

std::vector<calibration::OfferResult> offers_from(const v1::CreateFitResponse& response) {
  std::vector<calibration::OfferResult> offers;
  const auto optional = [](bool has, double value) {
    return has ? std::optional(value) : std::nullopt;
  };
  for (const auto& offer : response.offers()) {
    calibration::OfferResult one;
    one.name = offer.offer();
    one.output = offer.output();
    one.taken = terms_from(offer.taken_terms());
    one.left = terms_from(offer.left_terms());
    one.best_p = offer.best_p();
    one.u90_validation_before =
        optional(offer.has_u90_validation_before(), offer.u90_validation_before());
    one.u90_validation_after =
        optional(offer.has_u90_validation_after(), offer.u90_validation_after());
    one.u90_validation_forced =
        optional(offer.has_u90_validation_forced(), offer.u90_validation_forced());
    one.u90_blocks_before = optional(offer.has_u90_blocks_before(), offer.u90_blocks_before());
    one.u90_blocks_after = optional(offer.has_u90_blocks_after(), offer.u90_blocks_after());
    one.a90_validation_before =
        optional(offer.has_a90_validation_before(), offer.a90_validation_before());
    one.a90_validation_after =
        optional(offer.has_a90_validation_after(), offer.a90_validation_after());
    one.a90_validation_forced =
        optional(offer.has_a90_validation_forced(), offer.a90_validation_forced());
    one.a90_blocks_before = optional(offer.has_a90_blocks_before(), offer.a90_blocks_before());
    one.a90_blocks_after = optional(offer.has_a90_blocks_after(), offer.a90_blocks_after());
    offers.push_back(std::move(one));
  }
  return offers;
}

// Printed as a file's fit is printed: from the stored model itself, every digit of it.
ExitCode fit_at_daemon(const Session& session, const FitArguments& a) {
  auto wanted = fit_request_of(a.fit, a.runs);
  wanted.set_name(a.name);
  wanted.set_note(a.note);
  wanted.set_with_offers(a.fit.offers);
  const auto connection = session.connect();
  const auto response = ask_for_fit(connection, &ModelStub::CreateFit, wanted);
  const auto& created = response.model();
  v1::ExportModelRequest request;
  request.set_model_id(created.id());
  request.set_format(v1::ExportModelRequest::FORMAT_JSON);
  const auto model =
      formats::read_model_json(connection.ask(&ModelStub::ExportModel, request).text());
  if (!model)
    throw Failure{ExitCode::refused, "data_loss", model.error().reason,
                  "the daemon's model: " + model.error().message};
  print_fit(session.console, a.fit, *model, {}, offers_from(response), created.id());
  if (session.console.json) return ExitCode::done;
  print_stored(session.console, created, wanted);
  return ExitCode::done;
}

ExitCode fit(const Session& session, FitArguments& a) {
  if (a.file.empty() == a.runs.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string("fit what? found ") +
                      (a.file.empty() ? "neither a file nor --run" : "both a file and --run") +
                      "; give one: driftwise fit data.csv ..., or driftwise fit --run 3 ..."};
  if (!a.file.empty() && !(a.name.empty() && a.note.empty()))
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string(a.name.empty() ? "--note" : "--name") +
                      " is kept with a model that the daemon stores: it goes with --run. Rows of a "
                      "file become a run by driftwise data import"};
  if (a.fit.formula.starts_with('@')) a.fit.formula = read_input_file(a.fit.formula.substr(1));
  const bool needs_formula = a.method == "stepwise" || a.method == "classic";
  if (needs_formula && a.fit.formula.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "fit which model? give --model FORMULA, such as --model \"q ~ x + x^2 + T\""};
  if (a.method == "kinematic" && a.file.empty()) {
    v1::CreateKinematicModelRequest request;
    if (!a.methods.kinematics.empty())
      request.set_robot_toml(read_input_file(a.methods.kinematics));
    *request.mutable_fit() = fit_request_of(a.fit, a.runs);
    request.mutable_fit()->set_name(a.name);
    request.mutable_fit()->set_note(a.note);
    request.set_with_joint_errors(a.joint_errors);
    return create_kinematic_model(session, request);
  }
  if (a.joint_errors)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--joint-errors goes with --run and --method kinematic; of a file: driftwise "
                  "diagnose FILE.csv --kinematics ROBOT --robot-out FOUND"};
  if (a.method != "stepwise" && a.file.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--method " + a.method +
                      " works on a file only: driftwise data export RUN -o data.csv, then "
                      "driftwise fit data.csv"};
  if (a.method != "stepwise" && !a.fit.output.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "-o writes a model of terms: it goes with --method stepwise"};
  if (a.fit.format != "json" && a.fit.output.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--format " + a.fit.format +
                      " says how -o writes the model: give -o FILE, or leave it out"};
  if (a.method == "stepwise" && !(a.methods.kinematics.empty() && a.methods.together.empty()))
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string(a.methods.kinematics.empty() ? "--together" : "--kinematics") +
                      " goes with --method classic, kinematic or nominal"};
  if (a.method != "stepwise") {
    MethodsOfFile methods = a.methods;
    methods.methods = {a.method};
    return fit_file_by_method(session.console, a.fit, methods, InputText(a.file).text(), a.file);
  }
  if (!a.file.empty()) return fit_file(session.console, a.fit, InputText(a.file).text(), a.file);
  return fit_at_daemon(session, a);
}

}  // namespace

v1::CreateFitRequest fit_request_of(const FitOfFile& fit, const std::vector<std::int64_t>& runs) {
  refuse_file_options(fit);
  v1::CreateFitRequest request;
  for (const std::int64_t run : runs) request.add_run_ids(run);
  request.set_formula(fit.formula);
  request.set_select(fit.select);
  request.set_p_enter(fit.p_enter);
  request.set_p_remove(fit.p_remove);
  for (const auto& symbol : fit.exclude) request.add_exclude_symbols(symbol);
  request.set_first_rows(fit.first_rows);
  request.set_criterion(fit.criterion);
  request.set_hierarchy(fit.hierarchy);
  request.set_start_count(fit.starts);
  request.set_seed(fit.seed);
  for (const auto& term : fit.force) request.add_force_terms(term);
  for (const auto& term : fit.without) request.add_without_terms(term);
  request.set_weight_symbol(fit.weights);
  request.set_block_count(fit.blocks);
  request.set_thread_count(fit.threads);
  return request;
}

void add_fit_command(CLI::App& app, Session& session) {
  auto a = std::make_shared<FitArguments>();
  CLI::App& command = add_command(
      app, session, "fit",
      "Learns a model from a CSV file (here) or from runs (at the daemon, which stores it)",
      [&session, a] { return fit(session, *a); });
  command.add_option("FILE", a->file, "dataset CSV, - for standard input");
  command.add_option("--run", a->runs, "a run at the daemon instead; repeatable")
      ->allow_extra_args(false)
      ->check(positive_number());
  add_fit_options(command, a->fit);
  command.add_option("-o,--output", a->fit.output,
                     "write the model of a file to this file, without a daemon; else it is only "
                     "printed");
  command.add_option("--format", a->fit.format, "of that file: json, or c: one C99 function")
      ->check(CLI::IsMember({"json", "c"}))
      ->capture_default_str();
  command
      .add_option("--method", a->method,
                  "stepwise; kinematic: lengths and angles identified; of a file's fit also "
                  "classic: nominal kinematics plus an error fitted by the formula; nominal: the "
                  "drawing")
      ->check(CLI::IsMember({"stepwise", "classic", "kinematic", "nominal"}))
      ->capture_default_str();
  add_method_options(command, a->methods);
  command.add_flag("--joint-errors", a->joint_errors,
                   "with --run and --method kinematic, of an arm: errors of its joints that the "
                   "diagnosis finds are in");
  command.add_option("--name", a->name, "of the model that the daemon stores");
  command.add_option("--note", a->note, "kept with that model");
}

}  // namespace driftwise::cli
