#pragma once
// A running cell with the verbs of these tests: through the command line, the simulated cell's
// control port and the sqlite3 library, as an outsider would. Everything throws std::runtime_error
// when it cannot be done.

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/running_cell.h"
#include "tests/support/sql_query.h"

namespace driftwise::tests {

class CellAtWork : public RunningCell {
 public:
  using RunningCell::RunningCell;

  // Standard output of a command that must succeed.
  std::string say(const std::vector<std::string>& arguments) const;
  // The same with --json, parsed.
  nlohmann::json ask(std::vector<std::string> arguments) const;
  // The JSON of what went wrong: {"code", "reason", "message"}, and its exit code.
  nlohmann::json refusal(std::vector<std::string> arguments) const;
  // A line to the simulated cell: "fault break-beam".
  std::string control(const std::string& line) const;
  // A file in the cell's folder; its path.
  std::string write(const std::string& name, const std::string& text) const;
  std::string sql(const std::string& query) const { return query_one(database(), query); }
  std::int64_t count(const std::string& query) const { return count_of(database(), query); }

  // Starts a run of the trajectory and returns at once; its number.
  std::int64_t start_run(const std::string& trajectory_csv) const;
  nlohmann::json run(std::int64_t number) const;  // its record
  std::string state_of(std::int64_t number) const;
  // Waits for its end and returns its record; throws when it is not over within the limit.
  nlohmann::json end_of(std::int64_t number) const;
  void wait_for_points(std::int64_t count) const;
  // How often an event of this kind is on record.
  std::int64_t events(const std::string& what) const;
};

// Polls until it holds; throws with `what` when it does not within the limit, which allows for a
// busy machine.
void wait_until(const std::string& what, const std::function<bool()>& holds,
                std::chrono::milliseconds limit = std::chrono::seconds(60));

// A campaign as a trajectory: lines of `per_line` rows, each beginning with its return to zero;
// every third row is for validation.
std::string campaign(int lines, int per_line);

}  // namespace driftwise::tests
