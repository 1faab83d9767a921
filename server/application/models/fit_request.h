#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/ids.h"

namespace driftwise::application {

// A fit as a client asks for it.
struct FitRequest {
  std::vector<RunId> runs;
  std::string csv;  // instead of runs: a dataset as text
  std::string formula;
  std::string select = "stepwise";
  double p_enter = 0.05, p_remove = 0.10;
  std::string name, note;
  std::vector<std::string> exclude_channels;  // "t01": candidates left out
  std::int64_t first_rows = 0;                // fit only the first n rows; 0: all
  // As calibration::FitOptions and the command line have them.
  std::string criterion = "p";
  bool hierarchy = false;
  int starts = 1;
  std::int64_t seed = 1;
  std::vector<std::string> force_terms, without_terms;  // as a formula writes them
  std::optional<ModelId> parent;                        // for the lineage
  std::string weight_symbol;
  // Datasets::set_names of the data: filled in by the service that loads them.
  std::vector<std::string> set_names;
  int blocks = 10;
  int threads = 0;  // at most; 0: one, beside the cell's own work. The model is the same
};

}  // namespace driftwise::application
