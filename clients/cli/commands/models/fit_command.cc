#include "clients/cli/commands/models/fit_command.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <optional>

#include "clients/cli/commands/models/residuals_file.h"
#include "clients/cli/commands/models/validation_file.h"
#include "clients/cli/core/input_text.h"
#include "clients/cli/core/session.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/calibration/offer.h"
#include "server/core/reasons.h"
#include "server/effects/term_order.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/set_names.h"
#include "server/formats/export/model_c.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/fit_json.h"
#include "server/formats/model/model_json.h"
#include "server/formats/text/row_ranges.h"
#include "server/formats/text/text.h"
#include "server/identification/limits.h"
#include "server/threads/threaded_executor.h"

namespace driftwise::cli {
namespace {

std::vector<effects::Term> terms_of(const std::vector<std::string>& texts, const Dataset& data) {
  std::vector<effects::Term> terms;
  for (const auto& text : texts) terms.push_back(value_or_throw(formats::parse_term(text, data)));
  return terms;
}

std::string joined(const std::vector<effects::Term>& terms) {
  std::string text;
  for (const auto& term : terms) text += (text.empty() ? "" : ", ") + effects::notation(term);
  return text;
}

// Changes of the held-out A90: "+0.41 nm on the validation rows, -0.02 nm by blocks of time"; those
// that are not known are left out.
std::string changes_text(const calibration::OfferResult& offer, const SummaryUnit& summary) {
  std::string text;
  const auto add = [&](const std::optional<double>& before, const std::optional<double>& after,
                       const char* rows) {
    if (!before || !after) return;
    text += (text.empty() ? "" : ", ") + signed_fixed((*after - *before) * summary.factor, 2) +
            " " + summary.unit + rows;
  };
  add(offer.a90_validation_before, offer.a90_validation_after, " on the validation rows");
  add(offer.a90_blocks_before, offer.a90_blocks_after, " by blocks of time");
  return text.empty() ? "no rows are held out, so its gain is not known" : text;
}

SummaryUnit unit_of(const calibration::Model& model, const std::string& output) {
  for (const auto& one : model.outputs)
    if (one.channel.symbol == output) return summary_unit(one.channel.unit);
  return {"", 1};
}

nlohmann::ordered_json offers_json(const std::vector<calibration::OfferResult>& offers,
                                   const calibration::Model& model) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& offer : offers) {
    const SummaryUnit summary = unit_of(model, offer.output);
    nlohmann::ordered_json one{
        {"offer", offer.name}, {"output", offer.output}, {"best_p", offer.best_p}};
    for (const auto* key : {"taken", "left"}) one[key] = nlohmann::ordered_json::array();
    for (const auto& term : offer.taken) one["taken"].push_back(effects::notation(term));
    for (const auto& term : offer.left) one["left"].push_back(effects::notation(term));
    const auto put = [&](const std::string& key, const std::optional<double>& value) {
      if (value) one[key + "_" + summary.unit] = *value * summary.factor;
    };
    put("u90_validation_before", offer.u90_validation_before);
    put("u90_validation_after", offer.u90_validation_after);
    put("u90_validation_forced", offer.u90_validation_forced);
    put("u90_blocks_before", offer.u90_blocks_before);
    put("u90_blocks_after", offer.u90_blocks_after);
    put("a90_validation_before", offer.a90_validation_before);
    put("a90_validation_after", offer.a90_validation_after);
    put("a90_validation_forced", offer.a90_validation_forced);
    put("a90_blocks_before", offer.a90_blocks_before);
    put("a90_blocks_after", offer.a90_blocks_after);
    list.push_back(std::move(one));
  }
  return list;
}

void print_offers(std::ostream& out, const std::vector<calibration::OfferResult>& offers,
                  const calibration::Model& model) {
  out << "\nWhat more terms would add to the held-out A90\n";
  for (const auto& offer : offers) {
    const SummaryUnit summary = unit_of(model, offer.output);
    out << "  " << offer.output << ", " << offer.name << ": ";
    if (offer.taken_any())
      out << "stepwise takes " << joined(offer.taken) << ": " << changes_text(offer, summary)
          << '\n';
    else
      out << "all rejected (smallest p " << offer.best_p << ")\n";
  }
}

identification::Limit limit_of(const Dataset& data, const calibration::Model& model,
                               const calibration::OutputModel& output) {
  return identification::limited_by(identification::limit_facts(data, model, output));
}

// Beside those that the file marks itself.
void exclude_rows(Dataset& data, const std::string& text, const std::string& name) {
  if (text.empty()) return;
  if (data.excluded.empty()) data.excluded.assign(data.rows, 0);
  for (const std::int64_t row : value_or_throw(formats::parse_row_ranges(text))) {
    if (row < 1 || row > static_cast<std::int64_t>(data.rows))
      throw failure_of({ErrorCode::invalid_argument, "BAD_ROWS",
                        "--exclude-rows: found row " + std::to_string(row) + ", expected 1 to " +
                            std::to_string(data.rows) + ", the rows of " + name});
    data.excluded[static_cast<std::size_t>(row - 1)] = 1;
  }
}

// Names of the validation sets of file and --validation, per row of data; empty: there are none.
std::vector<std::string> joined_set_names(const Dataset& data, std::vector<std::string> others) {
  for (auto& word : others)  // every row of that file validates
    if (word == "calibration") word = "validation";
  std::size_t validating = 0;
  for (const auto set : data.set) validating += set == PointSet::validation ? 1 : 0;
  if (others.empty()) others.assign(validating, "validation");
  std::vector<std::string> names(data.rows - validating, "calibration");
  const bool leads = data.set.front() == PointSet::validation;  // its rows stand first
  names.insert(leads ? names.begin() : names.end(), others.begin(), others.end());
  return names;
}

void add_validation(RowsOfFile& rows, const FitOfFile& fit, const std::string& name) {
  if (fit.first_rows > 0)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--first and --validation do not go together: both say which rows calibrate"};
  const InputText text(fit.validation);
  const auto validation = value_or_throw(formats::read_dataset_csv(text.text(), fit.validation));
  for (const auto& column : rows.data.columns)
    if (validation.find(column.channel.symbol) == nullptr)
      rows.lacking.push_back(column.channel.symbol);
  if (!rows.data.dwell_s.empty() && validation.dwell_s.empty()) rows.lacking.emplace_back("dwell");
  rows.times_supposed = !times_are_related(rows.data, validation);
  rows.data = with_validation_rows(rows.data, name, validation, fit.validation);
  rows.set_names = joined_set_names(
      rows.data, value_or_throw(formats::read_set_names(text.text(), fit.validation)));
}

// Whether the fit may have a term of the formula.
bool is_offered(const effects::Term& term, const calibration::FitOptions& options) {
  const std::string text = effects::notation(term);
  for (const auto& out : options.excluded)
    if (effects::notation(out) == text) return false;
  return std::ranges::none_of(effects::symbols_of(term), [&options](const std::string& symbol) {
    return std::ranges::find(options.exclude_channels, symbol) != options.exclude_channels.end();
  });
}

void refuse_terms_of_other_rows(const FitOfFile& fit, const RowsOfFile& rows,
                                const calibration::FitOptions& options) {
  const auto refuse_lacking = [&](const std::string& symbol) {
    if (std::ranges::find(rows.lacking, symbol) != rows.lacking.end())
      throw Failure{ExitCode::bad_input, "invalid_argument", reasons::kUnknownChannel,
                    "--validation " + fit.validation + " has no channel '" + symbol +
                        "', which the model reads: none of its rows could be judged"};
  };
  for (const auto& output : options.candidates.outputs) refuse_lacking(output);
  std::vector<effects::Term> terms = options.forced;
  for (const auto& term : options.candidates.terms)
    if (is_offered(term, options)) terms.push_back(term);
  for (const auto& term : terms) {
    for (const auto& symbol : effects::symbols_of(term)) refuse_lacking(symbol);
    if (rows.times_supposed && depends_on_times(term))
      throw Failure{ExitCode::bad_input, "invalid_argument", reasons::kUntimed,
                    effects::notation(term) + ": when the rows of --validation " + fit.validation +
                        " were measured, before or after those of the first file, is not known; "
                        "give both files a line '# time_zero: 2026-11-30T08:00:00Z', the instant "
                        "that their time_s counts from"};
  }
}

// The model as `model export` writes it, the C functions named after the data's file.
std::string exported(const calibration::Model& model, const std::string& format,
                     const std::string& file) {
  if (format == "json") return formats::write_model_json(model, 2) + "\n";
  std::string name = std::filesystem::path(file).stem().string();
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return value_or_throw(formats::write_model_c(model, name));
}

}  // namespace

void add_fit_options(CLI::App& command, FitOfFile& fit) {
  command.add_option("--model", fit.formula,
                     "formula: \"q ~ poly(x, 3) + F + T + rate(T, 300 s) - t03\"; @FILE reads it "
                     "from a file");
  command.add_option("--select", fit.select, "stepwise, or all: every term, no selection")
      ->check(CLI::IsMember({"stepwise", "all"}))
      ->capture_default_str();
  command
      .add_option("--criterion", fit.criterion,
                  "of stepwise: p (thresholds on the partial F test), bic or aic (the change that "
                  "lowers it most, until none does)")
      ->check(CLI::IsMember({"p", "bic", "aic"}, CLI::ignore_case))
      ->capture_default_str();
  command.add_option("--p-enter", fit.p_enter, "a term enters below this p")->capture_default_str();
  command.add_option("--p-remove", fit.p_remove, "a term leaves above this p")
      ->capture_default_str();
  command.add_flag("--hierarchy", fit.hierarchy,
                   "a product or power only with its parents: x:t07 only with x and t07");
  command
      .add_option("--starts", fit.starts,
                  "the best of N starts: none, all, then random subsets; the lowest BIC (with "
                  "--criterion aic: AIC) wins")
      ->check(number_between(1, 10000))
      ->capture_default_str();
  command.add_option("--seed", fit.seed, "of the random starts")
      ->check(number_from_zero())
      ->capture_default_str();
  command
      .add_option(
          "--threads", fit.threads,
          "0: one per processor, or with --run one; the model is the same whatever the number")
      ->check(number_between(0, 1024))
      ->capture_default_str();
  command.add_option("--force", fit.force, "a term that is always in; repeatable")
      ->allow_extra_args(false);
  command.add_option("--without", fit.without, "a term that is left out; repeatable")
      ->allow_extra_args(false);
  command
      .add_option("--exclude", fit.exclude,
                  "channels whose terms are left out, such as t01,t02; repeatable")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--weights", fit.weights, "a channel that weights the rows, as 1/variance");
  command.add_option("--exclude-rows", fit.exclude_rows,
                     "rows of the file kept out of the fit, such as 12,40-45; the first is 1");
  command.add_option("--first,--first-rows", fit.first_rows, "calibrate on the first N rows only")
      ->check(positive_number());
  command.add_option("--blocks", fit.blocks, "blocks of time held out in turn; 0: none")
      ->check(number_between(0, 1000))
      ->capture_default_str();
  command.add_option("--residuals", fit.residuals,
                     "write measured, model and residual of every row to this file (dataset CSV)");
  command.add_option("--validation", fit.validation,
                     "a second dataset file, whose rows are the validation set of the first");
  command.add_flag("--history", fit.history, "show the selection step by step");
  command.add_flag("--offers", fit.offers,
                   "show what cross terms, derivatives and 4th order would add");
}

calibration::FitOptions fit_options(const FitOfFile& fit) {
  calibration::FitOptions options;
  options.select = fit.select == "all" ? calibration::Select::all : calibration::Select::stepwise;
  options.criterion =
      calibration::criterion_named(fit.criterion).value_or(calibration::Criterion::p);
  options.hierarchy = fit.hierarchy;
  options.starts = fit.starts;
  options.seed = fit.seed;
  options.executor =
      threads::threaded_executor(fit.threads == 0 ? threads::processors() : fit.threads);
  options.p_enter = fit.p_enter;
  options.p_remove = fit.p_remove;
  options.exclude_channels = fit.exclude;
  options.weight_symbol = fit.weights;
  options.first_rows = fit.first_rows;
  options.blocks = fit.blocks;
  options.stopwatch_us = [] {
    return std::chrono::duration<double, std::micro>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  return options;
}

void set_terms(const FitOfFile& fit, const RowsOfFile& rows, calibration::FitOptions& options) {
  if (!fit.formula.empty())
    options.candidates =
        value_or_throw(value_or_throw(formats::Formula::parse(fit.formula)).expand(rows.data));
  options.forced = terms_of(fit.force, rows.data);
  options.excluded = terms_of(fit.without, rows.data);
  std::vector<std::string> offered;
  for (const auto& term : options.candidates.terms) offered.push_back(effects::notation(term));
  for (std::size_t i = 0; i < options.excluded.size(); ++i) {
    const std::string term = effects::notation(options.excluded[i]);
    if (std::ranges::find(offered, term) != offered.end()) continue;
    const auto nearest =
        formats::nearest_word(term, std::vector<std::string_view>(offered.begin(), offered.end()));
    throw Failure{ExitCode::bad_input, "invalid_argument", "NOT_OFFERED",
                  "--without " + fit.without[i] + ": the formula offers no such term" +
                      (nearest.empty() ? "" : ", did you mean " + nearest + "?") +
                      " (--exclude leaves out every term of a channel)"};
  }
  refuse_terms_of_other_rows(fit, rows, options);
}

void require_validation_rows(const FitOfFile& fit, std::int64_t judged) {
  if (fit.validation.empty() || judged > 0) return;
  throw Failure{ExitCode::bad_input, "invalid_argument", reasons::kNoRows,
                "--validation " + fit.validation +
                    ": none of its rows can be judged: each lacks a value that the model reads, is "
                    "excluded, or is of a datum that the first file does not have"};
}

void refuse_fit_only_options(const FitOfFile& fit, const std::string& command) {
  const char* option = !fit.residuals.empty() ? "--residuals"
                       : fit.history          ? "--history"
                       : fit.offers           ? "--offers"
                                              : nullptr;
  if (option != nullptr)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string(option) + " is no option of " + command +
                      ": it goes with a fit of terms, driftwise fit DATA --model FORMULA"};
}

RowsOfFile rows_of_file(const FitOfFile& fit, std::string_view text, const std::string& name,
                        const calibration::Executor& executor) {
  if (fit.validation == "-" && name == "-")
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "the file and --validation are both standard input: give one of them a name"};
  RowsOfFile rows;
  rows.data = value_or_throw(formats::read_dataset_csv(text, name, executor));
  rows.set_names = value_or_throw(formats::read_set_names(text, name));
  exclude_rows(rows.data, fit.exclude_rows, name);
  if (!fit.validation.empty()) add_validation(rows, fit, name);
  if (formats::named_sets(rows.set_names).empty() || rows.set_names.size() != rows.data.rows)
    rows.set_names.clear();
  return rows;
}

void print_fit(const Console& console, const FitOfFile& fit, const calibration::Model& model,
               const Dataset& data, const std::vector<calibration::OfferResult>& offers,
               std::optional<std::int64_t> model_id) {
  if (console.json) {
    auto json = formats::fit_json(model);
    for (const auto& output : model.outputs) {
      const auto limit = limit_of(data, model, output);
      json["limited_by"].push_back(
          {{"output", output.channel.symbol}, {"cause", limit.cause}, {"words", limit.words}});
    }
    if (fit.offers) json["offers"] = offers_json(offers, model);
    if (model_id) json["model_id"] = *model_id;
    console.print_json(json);
    return;
  }
  console.out << formats::fit_table(model, {.history = fit.history});
  console.out << '\n';
  for (const auto& output : model.outputs) {
    if (data.rows == 0) break;  // a run's rows are at the daemon: nothing here tells what limits it
    console.out << output.channel.symbol << " is limited by " << limit_of(data, model, output).words
                << '\n';
  }
  if (fit.offers) print_offers(console.out, offers, model);
}

ExitCode fit_file(const Console& console, const FitOfFile& fit, std::string_view text,
                  const std::string& name) {
  calibration::FitOptions options = fit_options(fit);
  options.lineage.source = name;
  const RowsOfFile rows = rows_of_file(fit, text, name, options.executor);
  const Dataset& data = rows.data;
  options.set_names = rows.set_names;
  if (!fit.output.empty())
    options.lineage.dataset_hash = formats::content_hash(formats::write_dataset_csv(data));
  options.lineage.exclusions_hash = formats::exclusions_hash(data);
  set_terms(fit, rows, options);
  auto fitted = calibration::fit(data, options);
  if (!fitted) fitted.error().message.insert(0, name + ": ");  // which of many files
  const calibration::Model model = value_or_throw(std::move(fitted));
  require_validation_rows(fit, model.lineage.rows_validation);
  std::vector<calibration::OfferResult> offers;
  if (fit.offers)
    offers = value_or_throw(calibration::weigh_offers(
        data, options, model, calibration::published_offers(data, options.candidates)));
  const std::vector<std::string> read = {name, fit.validation};
  if (!fit.residuals.empty())
    write_output_file(fit.residuals,
                      formats::with_set_names(residuals_csv(data, model), rows.set_names), read);
  if (!fit.output.empty()) write_output_file(fit.output, exported(model, fit.format, name), read);
  print_fit(console, fit, model, data, offers, std::nullopt);
  for (const auto& written : {fit.residuals, fit.output})
    if (!written.empty() && !console.json) console.err << "wrote " << written << '\n';
  return ExitCode::done;
}

}  // namespace driftwise::cli
