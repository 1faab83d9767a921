#pragma once
// State of a cell at one instant.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/application/motion/lease_book.h"
#include "server/application/ports/database_health.h"
#include "server/application/recording/device_status.h"
#include "server/application/runs/run_progress.h"
#include "server/core/channel.h"
#include "server/core/records/stop_record.h"

namespace driftwise::application {

struct LatestValue {
  Channel channel;
  double value = kMissing;
  CellTime at;
  double age_s = 0;
  bool stale = true;
  std::string device;
};

// Age in s from which a value counts as stale: the one rule of status, alarms, page and command
// line. device: of the value; nullptr: none of this cell's, like the pose, which belongs to no one
// device. Nothing: it holds until somebody states another one, as what a person said does.
std::optional<double> stale_after_s(const DeviceDescription* device, std::string_view device_id);

struct CellStatus {
  std::string name, version, config_hash, web_address;
  Stamp now;
  Nanoseconds utc_offset{0};  // UTC minus cell time, now
  double speed = 1;
  std::vector<DeviceStatus> devices;
  std::vector<LatestValue> values;
  std::optional<RunProgress> run;  // the one under way
  std::optional<Lease> lease;      // its token blanked
  std::optional<ModelId> serving;
  DatabaseHealth database;
  std::vector<std::string> attention;              // sentences: what a person should look at
  double longest_pause_s = 0, recent_pause_s = 0;  // of the executor (pause_meter.h)
  std::vector<StopRecord> pending_stops;  // by controller; while there is one nothing may move
};

}  // namespace driftwise::application
