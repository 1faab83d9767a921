#pragma once
// Returns to zero as they were judged: what the limit was, what was expected, what was done.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/records/records.h"

namespace driftwise {

enum class ClosureDecision : std::uint8_t {
  within,     // the limit
  explained,  // beyond it, and what is expected accounts for the excess
  play,       // beyond it, and the same zero approached from the other side is within it
  marked,     // unexplained: the line is suspect, the datum stays
  repeated,   // unexplained: the line is measured again
  new_datum,  // unexplained: the line is suspect, a new datum follows
};
std::string_view to_string(ClosureDecision decision);
std::optional<ClosureDecision> closure_decision_from(std::string_view text);

// Budget of one coordinate, since the last good return: nm of a length, arcsec of a rotation.
struct ClosureCoordinate {
  std::string channel;     // "x_mm", "rx_arcsec"
  double found = 0;        // since the last good return from the same side
  double limit = 0;        // of its size
  double expected = 0;     // by the temperatures
  double expected_sd = 0;  // standard deviation of that
  double noise = 0;        // standard uncertainty that the instrument declares
  double play = 0;         // of this side against the last return, as far as the run has found it
  double unexplained() const { return found - expected; }
  bool operator==(const ClosureCoordinate&) const = default;
};

struct ClosureRecord {
  std::int64_t id = 0;
  RunId run;
  DatumId datum;
  std::int64_t line = 0;
  int repetition = 0;  // of the line: 0 is the first time
  Stamp measured;
  std::string side;  // from which each axis came: "q1+ q2-"; empty: not known
  std::string by;    // what the expectation rests on: "model 3", "4 earlier returns"; empty: none
  ClosureDecision decision = ClosureDecision::within;
  std::string sentence;
  std::vector<ClosureCoordinate> coordinates;
  bool operator==(const ClosureRecord&) const = default;
};

// What measuring a line again changes in its run.
struct RepeatedLine {
  std::vector<std::int64_t> rows;  // whose points are measured again
  std::int64_t given_up = 0;       // of the run's rows given up, those that are visited again
  Place place;                     // where the run goes on
};

}  // namespace driftwise
