#pragma once
// A whole cell on a thread of its own: what the doors (gRPC, web, command line) are tested against.
// The real services over a real SQLite file and the small world, in virtual time that stands still
// unless a test lets it pass. A test that must provoke an answer puts a fake of one small interface
// in the place of that service.

#include <atomic>
#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <queue>
#include <thread>

#include "tests/support/cell_in_memory.h"

namespace driftwise::tests {

namespace app = driftwise::application;

// Fakes in the place of services; none: the cell's own.
struct Fakes {
  app::Runs* runs = nullptr;
  app::Datasets* datasets = nullptr;
  app::Models* models = nullptr;
  app::ModelChecks* checks = nullptr;
  app::Targets* targets = nullptr;
  app::Configurations* configurations = nullptr;
  app::Diagnoses* diagnoses = nullptr;
  app::Extensions* extensions = nullptr;
  app::Improvements* improvements = nullptr;
  app::Studies* studies = nullptr;
  app::Feeds* feeds = nullptr;
  app::Alarms* alarms = nullptr;
};

class LiveCell {
 public:
  // diagnose: in the place of the search for causes.
  explicit LiveCell(app::Diagnose diagnose = {});
  ~LiveCell();  // whoever borrowed its services has gone

  app::Services services(const Fakes& fakes = {});

  // Runs work on the cell's thread and waits for it.
  template <class Work>
  auto on_executor(Work work) {
    std::promise<decltype(work())> done;
    post([&] {
      if constexpr (std::is_void_v<decltype(work())>) {
        work();
        done.set_value();
      } else {
        done.set_value(work());
      }
    });
    return done.get_future().get();
  }
  // The same with what is written to the record.
  template <class Work>
  auto on_store(Work work) {
    return on_executor([&] { return work(*store_); });
  }
  // Virtual time passes while this lives, whenever the cell has nothing left to do.
  std::shared_ptr<void> passing();

  CellTime now() {
    return on_executor([this] { return cell_->now(); });
  }
  EventId add_event(const std::string& what);  // in the record; nobody is told
  // The newest event of this kind; waits until there is one, at most 20 s of wall time.
  std::optional<EventRecord> last_event(const std::string& what);
  RunId add_run(const std::string& name = "test");  // in the record only: it is queued for ever
  DatumId add_datum(RunId run);
  // Accepted points of the run, a row each, on from the last.
  void add_points(RunId run, std::vector<PointRecord> points);
  void add_points(RunId run, int count) {
    add_points(run, std::vector<PointRecord>(static_cast<std::size_t>(count)));
  }
  // q1 = 1e-6 + x of this formula, with plausible figures; its own hash.
  ModelId add_model(const std::string& formula) {
    return on_executor([&] { return put_model(formula); });
  }

  // For fakes, on the cell's thread.
  ModelId put_model(const std::string& formula);
  Store& store() { return *store_; }
  std::string database() const { return folder_ / "cell.sqlite"; }

  SmallWorld world;  // on the cell's thread

 private:
  void post(std::function<void()> job);
  void run();

  Folder folder_;
  Store* store_ = nullptr;  // the writing one
  std::unique_ptr<CellInMemory> cell_;
  std::mutex mutex_;
  std::condition_variable called_;
  std::queue<std::function<void()>> jobs_;
  std::atomic<int> passing_ = 0;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace driftwise::tests
