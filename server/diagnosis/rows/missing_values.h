#pragma once
// Conditions that some rows have no value of. A scanner that answers every tenth row has a
// temperature in between; a load cell that fell out for an hour has none, and a column's mean in
// its place would be a reading of something else. And rows that are there twice.

#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/diagnosis/rows/rows_needed.h"

namespace driftwise::diagnosis {

struct WithoutGaps {
  // Short gaps of temperatures and air are closed along straight lines in time; rows that still
  // lack a condition are excluded where they are few, and those of untimed data that repeat an
  // earlier one.
  Dataset data;
  // Symbols that more rows lack than can be spared: nothing reads them.
  std::vector<std::string> unread;
  std::vector<std::string> sentences;  // of all three, for warnings
  std::size_t left_out = 0;            // rows, for what they lack
};

// conditions: symbols of the channels that are looked at. In the catalogue's units.
WithoutGaps without_gaps(Dataset data, const std::vector<std::string>& conditions);

// The same once more, of thermometers whose wrong readings mend_sensors() has blanked since, but
// dead ones. Rows in which a thermometer of the baseline has no value are left out by themselves.
void close_gaps_of(const std::vector<FaultySensor>& sensors, const LivingBaseline& living,
                   WithoutGaps& whole);

}  // namespace driftwise::diagnosis
