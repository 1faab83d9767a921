#pragma once
// `driftwise fit FILE.csv --model FORMULA`: a fit of a plain CSV file, here, without a daemon.
// Given the CSV that a daemon exported and the same options it gives the daemon's model to the last
// digit: both call calibration::fit.

#include <CLI/App.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/cli/core/console.h"
#include "server/calibration/fit.h"
#include "server/calibration/offer.h"

namespace driftwise::cli {

struct FitOfFile {
  std::string formula, select = "stepwise";
  std::string criterion = "p";
  double p_enter = 0.05, p_remove = 0.10;
  bool hierarchy = false;
  int starts = 1;
  std::int64_t seed = 1;
  int threads = 0;                          // 0: one per processor
  std::vector<std::string> force, without;  // terms as a formula writes them
  std::vector<std::string> exclude;         // channel symbols
  std::string weights;                      // channel symbol
  std::string exclude_rows;                 // of a file, counted from 1: "12,40-45"
  std::int64_t first_rows = 0;
  int blocks = 10;
  std::string residuals;                // a file to write them to
  std::string output, format = "json";  // a file for the model itself; json or c
  std::string validation;  // a file whose rows are the validation set: validation_file.h
  bool history = false;    // print the selection step by step
  bool offers = false;     // print what the published study's further terms would add
};

// Rows that a fit is made of.
struct RowsOfFile {
  Dataset data;
  std::vector<std::string> set_names;  // FitOptions::set_names
  std::vector<std::string> lacking;    // channels that --validation's file does not have: symbols
  bool times_supposed = false;         // when the second file began is not known
};

// Adds the options of a fit to a command: --model to --offers. fit outlives the command.
void add_fit_options(CLI::App& command, FitOfFile& fit);

// What the options say, without the formula. Throws Failure (bad_input) for a term that does not
// parse.
calibration::FitOptions fit_options(const FitOfFile& fit);

// The terms: what the formula offers, --force and --without. Throws Failure (bad_input) for a term
// that does not parse, for a --without that is none of those offered, and for a term that rows of
// --validation have no value of.
void set_terms(const FitOfFile& fit, const RowsOfFile& rows, calibration::FitOptions& options);

// Throws Failure (bad_input) where --validation names a file and none of its rows was judged.
void require_validation_rows(const FitOfFile& fit, std::int64_t judged);

// Throws Failure (usage) for an option of a fit that shows or writes what only `fit` of a model of
// terms has. command: for the sentence, "model sensors".
void refuse_fit_only_options(const FitOfFile& fit, const std::string& command);

// The rows of a file as the options have them: those of --exclude-rows kept out, those of
// --validation beside them; that file is read once. Throws Failure (bad_input) with the reader's
// reason.
RowsOfFile rows_of_file(const FitOfFile& fit, std::string_view text, const std::string& name,
                        const calibration::Executor& executor);

// A page, or with --json driftwise.fit.v1; offers only where fit.offers asks for them. data: what
// it was fitted to, for what limits it; empty where it is not at hand. model_id: where a daemon
// stored it.
void print_fit(const Console& console, const FitOfFile& fit, const calibration::Model& model,
               const Dataset& data, const std::vector<calibration::OfferResult>& offers,
               std::optional<std::int64_t> model_id);

// Fits text, the contents of the file called name, and prints the model: a page, or with --json
// driftwise.fit.v1. Throws Failure (bad_input) with the reason of the reader, the formula or the
// fit.
ExitCode fit_file(const Console& console, const FitOfFile& fit, std::string_view text,
                  const std::string& name);

}  // namespace driftwise::cli
