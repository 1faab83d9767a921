#pragma once
// Entries of the table of lies: the smallest size that is found, the time that takes, and what is
// demanded at twice that size.

#include <iosfwd>
#include <string>

#include "tests/faults/lies/lie_bench.h"

namespace driftwise::lies {

enum class Effort : std::uint8_t {
  quick,
  whole
};  // whole: also half the expected size and the size

struct Entry {
  std::string not_detectable;  // why; else empty
  std::optional<double> size;  // the smallest that was found; none: a lie without a size
  Episode at_smallest, at_twice;
  std::string problem;  // what was demanded and is not so; empty: all of it is
};

Entry measure(LieBench& bench, const ChannelOfCell& channel, Kind kind, Effort effort);

// The whole table of one cell as Markdown. Result: the number of entries with a problem, which are
// named at the end.
int print_table(const std::string& cell, Effort effort, std::ostream& out);

}  // namespace driftwise::lies
