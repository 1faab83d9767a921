#pragma once
// A diagnosis as the daemon keeps it: whole, and exact both ways, so that what is shown, exported
// or accepted after a restart is what was found. Two parts: everything but the rows as JSON (schema
// driftwise.stored_diagnosis.v1; a person reads it in the database), the rows for plots as CBOR.
// What clients print is another text: diagnosis_json.h.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::formats {

// Per row of the dataset that was looked at: what a plot of the discrepancy needs.
struct DiscrepancyRows {
  struct Column {
    std::string symbol, unit;
    std::vector<double> values;
  };
  struct Output {
    std::string output, unit;
    std::vector<double> before, after;
  };
  std::vector<double> time_s;  // row numbers where the data are untimed
  std::vector<std::uint8_t> validation;
  std::vector<double> line;
  std::vector<Column> variables;
  std::vector<Output> outputs;
};

// At most this many rows are kept: every k-th, counted from the first. A weekend's 216 000 rows of
// 30 channels would be 50 MB, and no plot shows them.
constexpr std::size_t kMostPlotRows = 20'000;

// Channels that vary, and the outputs' discrepancy before and after.
DiscrepancyRows discrepancy_rows(const Dataset& dataset, const diagnosis::Diagnosis& diagnosis,
                                 std::size_t most = kMostPlotRows);

// As much of the dataset as they kept: time, sets, lines, channels that vary. Puts the outputs'
// before and after back into the diagnosis.
Dataset dataset_of(const DiscrepancyRows& rows, diagnosis::Diagnosis& diagnosis);

std::string write_discrepancy_rows(const DiscrepancyRows& rows);
// Errors: data_loss BAD_ROWS (no CBOR, deeper than ours, columns of unequal length).
Result<DiscrepancyRows> read_discrepancy_rows(std::string_view bytes);

// Without OutputSummary::before and after: those are in the rows.
std::string write_stored_diagnosis(const diagnosis::Diagnosis& diagnosis);
// Errors: data_loss BAD_DIAGNOSIS, naming the place.
Result<diagnosis::Diagnosis> read_stored_diagnosis(std::string_view text);

}  // namespace driftwise::formats
