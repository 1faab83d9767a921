#pragma once
// Lines that a reader can copy, for every command: in its --help and on its man page. A test parses
// each of them, so none can fall behind the options.

#include <span>
#include <string_view>

namespace driftwise::cli {

struct Example {
  std::string_view verb;  // "run start": whose example it is
  std::string_view line;  // the whole line: "driftwise run start plan.csv --watch"
  std::string_view what;
};

// In the order of the verbs; those of one verb stand together.
std::span<const Example> all_examples();
// Those of one command; none: there are none.
std::span<const Example> examples_of(std::string_view verb);

}  // namespace driftwise::cli
