#pragma once
// The whole of Driftwise on loopback: driftwise-cellsim and driftwised as processes, in a folder of
// their own, on free ports. Fixture of the integration, fault and demo tests. Not thread safe;
// throws std::runtime_error when something does not start.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "driftwise/v1/run.pb.h"
#include "tests/support/process.h"

namespace grpc {
class Channel;
}

namespace driftwise::tests {

struct CellOptions {
  double speed = 200;
  int seed = 1;
  std::string cell = "linear-axis";            // folder under deploy/cells
  std::string cell_file{};                     // another one for that plant, under tests/data/cells
  std::vector<std::string> cellsim_options{};  // "--set", "key=value", ...
  std::vector<std::string> environment{};      // "NAME=value", of both programs
};

class RunningCell {
 public:
  explicit RunningCell(CellOptions options = {});  // starts the simulated cell, not yet the daemon
  ~RunningCell();

  // Puts other text into the instance's cell.toml, wherever `found` stands; throws when it does
  // not. Before start_daemon().
  void edit_cell_file(const std::string& found, const std::string& instead) const;
  void start_daemon(const std::vector<std::string>& environment = {});
  void kill_daemon();  // SIGKILL, at once
  int stop_daemon();   // SIGTERM; its exit code
  Process& daemon() { return *daemon_; }
  Process& cellsim() { return *cellsim_; }

  std::string folder() const { return folder_.path(); }
  std::string database() const;  // path of the SQLite file
  std::string grpc_address() const { return grpc_; }
  std::string target_line_address() const { return target_line_; }
  std::string http_address() const { return http_; }  // "127.0.0.1:40201"
  std::string device_address(const std::string& id) const;
  std::shared_ptr<grpc::Channel> channel() const { return channel_; }
  std::string daemon_log() const;  // all its starts

  // The command line against this daemon, to its end.
  Finished cli(std::vector<std::string> arguments,
               std::chrono::milliseconds limit = std::chrono::seconds(60)) const;
  // The same as a process to follow; standard error goes to folder()/cli.log.
  Process cli_process(std::vector<std::string> arguments) const;

  std::string take_lease();
  // With the request_id of an earlier call: that call's run.
  v1::Run create_run(const std::string& trajectory_csv, const std::string& request_id = {});
  // Returns when the run is over or the time ran out (then the state says so).
  v1::Run wait_until_over(std::int64_t run_id, std::chrono::milliseconds limit);

 private:
  CellOptions options_;
  TemporaryFolder folder_;
  std::unique_ptr<Process> cellsim_, daemon_;
  std::string ready_line_, grpc_, target_line_, http_;
  std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace driftwise::tests
