#pragma once
// The outside watcher of the crash tests: remembers every point that the daemon has told anybody
// about, with its values, and afterwards holds the database against it. It reads the database with
// the sqlite3 library alone, not with our store.

#include <grpcpp/channel.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <thread>

namespace driftwise::tests {

struct SeenPoint {
  std::int64_t id = 0, row = 0;
  std::string values;
};  // values: the message as text, exact

class PointWatcher {
 public:
  PointWatcher(std::shared_ptr<grpc::Channel> channel,
               std::int64_t run_id);  // starts to watch on a thread of its own
  ~PointWatcher();
  void join();  // returns when the daemon is gone or the run is over
  const std::map<std::int64_t, SeenPoint>& seen() const { return seen_; }  // by row; after join()
  std::int64_t acknowledged_count() const {
    return acknowledged_;
  }  // the largest accepted_count that was told

 private:
  void watch();
  void fetch();
  std::shared_ptr<grpc::Channel> channel_;
  std::int64_t run_id_;
  std::map<std::int64_t, SeenPoint> seen_;
  std::int64_t last_point_id_ = 0, acknowledged_ = 0;
  std::thread thread_;
};

// Every point of the run as the API tells it now, by row. Throws when a row is there twice.
std::map<std::int64_t, SeenPoint> points_by_row(const std::shared_ptr<grpc::Channel>& channel,
                                                std::int64_t run_id);

// "ok" or what SQLite's integrity_check says; and how often (run, row) pairs stand twice among the
// points.
std::string integrity_of(const std::string& database);
std::int64_t doubled_points_in(const std::string& database);

}  // namespace driftwise::tests
