#pragma once
// What takes part in a join of runs, what the join is held to, and what it reports
// (docs/joined-runs.md).

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/ids.h"
#include "server/core/trajectory/trajectory.h"
#include "server/correction/correction.h"

namespace driftwise::correction {

// One run, or one dataset file.
struct JoinPart {
  std::string name;  // "run 3", "x.csv": in messages and in the report
  Dataset data;
  // Row of the trajectory, counted from 0, of each row of the data; each once. Empty: a file, whose
  // rows are in the order of its trajectory.
  std::vector<std::int64_t> row;
  std::optional<Trajectory> trajectory;   // none: motor coordinates are compared instead
  std::string tool;                       // empty: not said
  std::string model;                      // that the motion was compensated with; empty: none
  std::vector<ChannelValue> datum;        // temperatures at its datums; empty: of its first return
  std::optional<Stage> stage;             // correction stage of its cell
  std::string hash;                       // of its data
  std::vector<CorrectionId> corrections;  // that are in its data, ascending

  std::int64_t row_of(std::size_t index) const {
    return row.empty() ? static_cast<std::int64_t>(index) : row[index];
  }
};
using JoinParts = std::vector<JoinPart>;

struct JoinRules {
  bool subtract_returns = false;
  double max_temperature_difference_k = 0.5;  // of one thermometer between the datums of two runs
  // Of a motor coordinate between two runs: at pose zero and, without trajectories, in each row.
  double max_zero_difference_mm = 2e-3;
};

// Difference between two runs that measured one channel, over the common rows.
struct JoinCheck {
  std::string first, second;  // names of the parts
  std::size_t rows = 0;
  double median = 0;             // first - second
  double sigma = 0;              // without rows far off: robust.h
  double largest = 0;            // deviation from the median
  std::int64_t largest_row = 0;  // of the trajectory, from 0
};

struct JoinedChannel {
  Channel channel;
  std::vector<std::string> sources;  // names of the parts; the value is their mean
  // Standard uncertainty of the join, in the channel's unit; pose coordinates only.
  std::optional<double> u;
  std::optional<JoinCheck> check;  // in the channel's unit; of the two sources that differ most
};

struct JoinReport {
  std::size_t rows = 0, unmatched_rows = 0;  // unmatched: one of the parts lacks the row
  std::vector<JoinedChannel> channels;
  std::vector<std::string> warnings;
  std::optional<double> temperature_difference_k;  // the largest between datums
  std::string temperature_channel;
  std::optional<double> zero_difference_mm;  // the largest of a motor coordinate at pose zero
};

// "run 3, run 4"
std::string names_of(const JoinParts& parts);

}  // namespace driftwise::correction
