#pragma once
// The two robots of an indentation behind a daemon: moved with a lease, looked at through the
// stream of readings. Made and used on one thread; the stream has its own.

#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>

#include "clients/cli/commands/indentation/indent_motors.h"
#include "clients/cli/core/connection.h"
#include "clients/cli/core/held_lease.h"
#include "driftwise/v1/cell_service.pb.h"
#include "server/formats/indentation/indentation_file.h"

namespace driftwise::cli {

// A lost daemon or a person's Ctrl-C is an error of the next call; the robots hold where they are.
class WireCell final : public indentation::TouchingCell {
 public:
  // Takes the lease. answer: about a run that stands. Throws Failure: lease, unreachable daemon, no
  // such axis. commanded_mm: what the robot above was told last, by an earlier client.
  WireCell(const Connection& connection, const formats::IndentationFile& file,
           v1::HoldAnswer answer);
  ~WireCell() override;

  Result<Answer> move_above(double x_mm, double y_mm, double z_mm) override;
  Result<Answer> move_below(double rx_arcsec, double ry_arcsec, double z_mm) override;
  // By the read-back of the robot's own axes, which count upwards. Also after an interrupt: it is
  // how a contact is ended.
  Result<Answer> retract_below(double rx_arcsec, double ry_arcsec, double z_mm) override;
  Result<void> nudge_above(double dx_mm, double dy_mm) override;
  Result<Eigen::MatrixXd> look() override;
  Result<void> wait(double cell_s) override;
  Result<Here> here() override;
  std::string utc() override;

 private:
  struct Channel {
    double value = 0;
    std::int64_t count = 0;  // readings of it so far
  };

  void follow();
  Result<void> interrupted() const;
  std::string live_channel(const std::string& coordinate);  // "mn.x_mm"
  Result<Motors> present(const Motors& of);
  Result<void> move(const Motors& motors);
  // readings new values of each channel, all begun after the call: a row per reading.
  Result<Eigen::MatrixXd> collect(const std::vector<std::string>& channels, int readings);

  const Connection connection_;  // not cancelled by an interrupt
  const Connection& asked_;
  const formats::IndentationFile& file_;
  v1::HoldAnswer answer_;
  HeldLease lease_;
  double speed_ = 1;
  IndentMotors motors_;
  IndentPose wanted_;
  Motors commanded_;

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::map<std::string, Channel> latest_;
  std::string lost_;  // why the stream ended
  google::protobuf::Timestamp last_;
  grpc::ClientContext stream_;  // of the thread's call; cancelled at the end
  std::thread thread_;
};

}  // namespace driftwise::cli
