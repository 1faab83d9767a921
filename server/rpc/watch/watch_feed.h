#pragma once
// One look at the cell for all who watch. On the cell's executor it costs one status() at most
// twenty times a second and one query when the record has grown, however many clients there are;
// everything else (conversion, what each client gets) happens on the watch thread. Without clients
// it does nothing.
//
// Thread: made, used and destroyed on the watch thread; the cell is only touched on its own
// executor. Both must run until the last subscription is gone.

#include <boost/asio/any_io_executor.hpp>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "driftwise/v1/watch_service.pb.h"
#include "server/application/cell/services.h"
#include "server/application/diagnoses/diagnosis_progress.h"
#include "server/application/improvement/improvements.h"
#include "server/application/status/cell_status.h"
#include "server/rpc/watch/watch_cursor.h"

namespace driftwise::rpc {

struct WatchTick {  // states; each with a number that grows when it is news
  v1::ChannelLayout layout;
  v1::ValuesUpdate values;
  v1::GetStatusResponse cell;  // without values
  std::optional<v1::RunProgress> progress;
  std::vector<v1::WatchEvent> jobs;    // diagnoses and improvements under way
  std::vector<v1::WatchEvent> alarms;  // that are not so on record, while it takes nothing
  std::int64_t alarms_number = 0, values_number = 0, cell_number = 0, progress_number = 0,
               jobs_number = 0;
  CellTime cell_time;
  WatchCursor head;  // the newest records there are
};

struct WatchChunk {  // records between two cursors
  RecordCursor from, to;
  std::vector<v1::WatchEvent> events;
};

struct RecordHead {
  std::string database;  // its own name
  RecordCursor newest;
};

class WatchFeed : public std::enable_shared_from_this<WatchFeed> {
 public:
  WatchFeed(const application::Services& cell, asio::any_io_executor watch_thread);
  ~WatchFeed();

  asio::any_io_executor executor() const { return watch_thread_; }
  // wake: called when tick() or chunk_after() may have news, until the handle is gone.
  std::shared_ptr<void> subscribe(std::function<void()> wake);
  const std::shared_ptr<const WatchTick>& tick() const { return tick_; }  // none yet: empty
  // What follows this cursor, if it is still in memory.
  std::shared_ptr<const WatchChunk> chunk_after(const RecordCursor& cursor) const;
  // Else from the store: answers on the watch thread. then: not called when the feed has gone.
  void fetch(const RecordCursor& after, const RecordCursor& until,
             std::function<void(Result<WatchChunk>)> then);

 private:
  class Look;  // the half on the cell's executor
  class Back;  // its way back, which ends with the feed
  struct News {
    std::shared_ptr<const application::CellStatus> status;
    bool values = false, cell = false, progress = false, jobs = false;
    std::vector<application::DiagnosisProgress> diagnoses;  // under way, when there is news of jobs
    std::vector<application::ImprovementProgress> improvements;
    std::vector<AlarmRecord> alarms;  // that are not so on record
    RecordHead head;
    std::vector<std::pair<RecordCursor, RecordPage>> pages;  // each with where it begins
  };
  void take(News news);
  static void take_states(const News& news, WatchTick& tick);
  void forget_oldest();

  application::Services cell_;
  asio::any_io_executor watch_thread_;
  std::shared_ptr<Back> back_;
  std::shared_ptr<Look> look_;
  std::map<std::int64_t, std::function<void()>> wakes_;
  std::int64_t last_subscription_ = 0;
  std::shared_ptr<const WatchTick> tick_;
  std::deque<std::shared_ptr<const WatchChunk>> chunks_;  // adjoining, oldest first
  std::size_t events_kept_ = 0;
};

}  // namespace driftwise::rpc
