#pragma once
// The private record of the truth: a CSV that only tests and the demo's final table read.
//
// Columns: time_ns (cell UTC), kind, then those of the plant (truth_columns(): docs/plants). kind:
// "zero" (an interferometer was zeroed), "length" (middle of a reading), "reference", "load" (the
// weights begin to change), "tick" (every 10 s). To judge a reading: the row of kind length whose
// time lies between the reading's start and end, minus the last row of kind zero before it. Numbers
// are shortest round trip. Every line is written to the file system at once.

#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

class TruthLog {
 public:
  // Creates or continues the file; a new one gets the header. Throws std::runtime_error when it
  // cannot be opened.
  TruthLog(const std::filesystem::path& file, std::span<const std::string> columns);
  void append(std::string_view kind, TimeNs time, std::span<const double> values);

 private:
  std::ofstream out_;
};

}  // namespace driftwise::simulated
