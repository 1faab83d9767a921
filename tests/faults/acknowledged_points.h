#pragma once
// The outside watcher of the crash tests: remembers every point that the daemon has told anybody
// about, with its values.

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <thread>

namespace grpc {
class Channel;
}

namespace driftwise::tests {

struct SeenPoint {
  std::int64_t id = 0, row = 0;
  std::string values;  // the message as text, exact
};
using PointsByRow = std::map<std::int64_t, SeenPoint>;

class PointWatcher {
 public:
  // Starts to watch on a thread of its own.
  PointWatcher(std::shared_ptr<grpc::Channel> channel, std::int64_t run_id);
  ~PointWatcher();
  PointWatcher(const PointWatcher&) = delete;
  PointWatcher& operator=(const PointWatcher&) = delete;
  void join();  // returns when the daemon is gone or the run is over
  const PointsByRow& seen() const { return seen_; }  // after join()
  // The largest accepted_count that was told. A point counts as acknowledged from then on, whether
  // or not there was time left to fetch it.
  std::int64_t acknowledged_count() const { return acknowledged_; }

 private:
  void watch();
  void fetch();
  std::shared_ptr<grpc::Channel> channel_;
  std::int64_t run_id_;
  PointsByRow seen_;
  std::int64_t last_point_id_ = 0;
  std::atomic<std::int64_t> acknowledged_ = 0;
  std::thread thread_;
};

// Every point of the run as the API tells it now. Throws when a row is there twice.
PointsByRow points_by_row(const std::shared_ptr<grpc::Channel>& channel, std::int64_t run_id);

}  // namespace driftwise::tests
