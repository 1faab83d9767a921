#pragma once
// Conditions that some rows have no value of. A scanner that answers every tenth row has a
// temperature in between; a load cell that fell out for an hour has none, and a column's mean in
// its place would be a reading of something else. And rows that are there twice.

#include <string>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::diagnosis {

struct WithoutGaps {
  // Short gaps of temperatures and air are closed along straight lines in time; rows that still
  // lack a condition are excluded where they are few, and those of untimed data that repeat an
  // earlier one.
  Dataset data;
  // Symbols that more rows lack than can be spared: nothing reads them.
  std::vector<std::string> unread;
  std::vector<std::string> sentences;  // of all three, for warnings
};

// conditions: symbols of the channels that are looked at. In the catalogue's units.
WithoutGaps without_gaps(Dataset data, const std::vector<std::string>& conditions);

}  // namespace driftwise::diagnosis
