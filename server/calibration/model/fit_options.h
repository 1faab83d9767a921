#pragma once
// Options of a fit: candidates, selection rule, weights, held-out blocks. server/calibration/fit.h
// uses them; every stage of a fit reads the part that concerns it.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "server/calibration/model/criterion.h"
#include "server/calibration/model/executor.h"
#include "server/calibration/model/model.h"
#include "server/calibration/model/solver.h"
#include "server/effects/term.h"

namespace driftwise::calibration {

enum class Select { stepwise, all };

// A formula applied to one dataset: outputs and candidate terms. server/formats/formula makes it.
struct Candidates {
  std::string formula;               // canonical, for the record
  std::vector<std::string> outputs;  // symbols: "q1"
  std::vector<effects::Term> terms;  // without the constant, each once; their order breaks ties
  bool constant = true;              // false: "- 1", only with Select::all
};

struct FitOptions {
  Candidates candidates;
  Select select = Select::stepwise;
  Criterion criterion = Criterion::p;      // what stepwise strives for: stepwise.h
  double p_enter = 0.05, p_remove = 0.10;  // criterion p; strict; p_remove >= p_enter
  bool hierarchy = false;                  // a product or power only with its parents: hierarchy.h
  int starts = 1;         // 1: from none; more: the best of several starts: starts.h
  std::int64_t seed = 1;  // of the random starts
  std::vector<effects::Term>
      forced;  // in from the start and never removed; added to the candidates if missing
  std::vector<effects::Term> excluded;        // candidates left out
  std::vector<std::string> exclude_channels;  // symbols: every candidate that reads one is left out
  std::string weight_symbol;    // a channel whose values weight the rows (1/variance); "": all 1
  std::int64_t first_rows = 0;  // calibrate on the first n rows of the dataset only; 0: all
  int blocks = 10;              // held out in turn for u90_blocks; below 2: not done
  double block_gap = 0.25;      // of a block's rows, left out of the training on either side of it
  Lineage lineage;  // runs, source, hash, parent: passed on; the row counts are filled in
  // Per row of the dataset "calibration", "validation" or the name of its validation set; empty: no
  // set has a name.
  std::vector<std::string> set_names;
  bool move_datums = true;  // further datums by where their zeros lie, not only by a constant:
                            // datum_zeros.h
  Solver solver = Solver::automatic;  // how rows become a triangle: row_reduction.h
  Executor executor;
  std::function<double()> stopwatch_us;  // for Model::fit_us (triangle, selection, solution);
                                         // empty: 0. No clock is read here
};

}  // namespace driftwise::calibration
