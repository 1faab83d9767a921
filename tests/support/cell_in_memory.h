#pragma once
// A whole Cell on one thread: virtual time, the small world, a real SQLite file. Verbs for tests.

#include <boost/asio/co_spawn.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "server/application/alarms/alarms.h"
#include "server/application/analyses/studies.h"
#include "server/application/annotations/annotations.h"
#include "server/application/cell/cell.h"
#include "server/application/checks/model_checks.h"
#include "server/application/commissioning/commissioning.h"
#include "server/application/configuration/configurations.h"
#include "server/application/datasets/datasets.h"
#include "server/application/diagnoses/diagnoses.h"
#include "server/application/diagnoses/extensions.h"
#include "server/application/holds/holds.h"
#include "server/application/improvement/improvements.h"
#include "server/application/look_back/look_back.h"
#include "server/application/manual/jogs.h"
#include "server/application/manual/manual_control.h"
#include "server/application/models/models.h"
#include "server/application/models/promotions.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/ports/host.h"
#include "server/application/provenance/provenance.h"
#include "server/application/queue/queue.h"
#include "server/application/runs/runs.h"
#include "server/application/serving/targets.h"
#include "server/application/status/overview.h"
#include "server/application/support/support_bundles.h"
#include "server/application/trajectories/trajectories.h"
#include "server/application/watching/feeds.h"
#include "tests/support/small_world.h"

namespace driftwise::tests {

inline constexpr CellTime kWorldBegin{1'795'248'000'000'000'000};  // 2026-11-21T08:00:00Z

// A folder of its own that goes with it.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

class CellInMemory {
 public:
  struct Further {
    CellTime begin = kWorldBegin;
    application::Diagnose diagnose = {};              // what stands in for the search for causes
    asio::any_io_executor diagnosis_thread = {};      // where it runs; empty: with everything else
    asio::any_io_executor text_thread = {};           // where texts are read; empty: likewise
    std::string boot_id = "first";                    // of the computer
    std::function<void()> end_daemon = {};            // the cell asks for its own end
    std::unique_ptr<Notifier> notifier = {};          // the way out; empty: nobody is told
    std::optional<formats::KeptStop> kept_stop = {};  // asked for while no daemon answered
  };
  CellInMemory(SmallWorld& world, CellDescription description, OpenStore open_store,
               Further further);
  // Any devices, made when the time is there.
  using MakeDevices =
      std::function<application::Devices(VirtualTime& time, const CellDescription& description)>;
  CellInMemory(const MakeDevices& make_devices, CellDescription description, OpenStore open_store,
               Further further);
  // world: outlives this; begin: where cell time starts, later than any run that is gone on with.
  CellInMemory(SmallWorld& world, CellDescription description, OpenStore open_store,
               CellTime begin = kWorldBegin);
  ~CellInMemory();  // shuts down in good order, when that has not been done

  const application::Services& operator*() const { return cell_->services(); }
  const application::Services* operator->() const { return &cell_->services(); }
  application::Cell& cell() { return *cell_; }
  application::CellStatus status() const { return cell_->services().overview.status(); }

  // Queries of the store, on the reader's thread.
  template <class Query>
  auto read(Query query) const {
    return cell_->services().records.call(std::move(query));
  }
  auto run(RunId id) const { return cell_->services().runs.get(id); }
  auto runs(int limit, std::int64_t before_id) const {
    return read([=](Store& store) { return store.runs().runs(limit, before_id); });
  }
  // Those of the plan's rows. at_every_place: and the passages beside it, in the order of time.
  auto points(RunId id, std::int64_t after_id, int limit, bool at_every_place = false) const {
    return read([=](Store& store) {
      auto found = store.points().points(id, after_id, limit);
      if (found && !at_every_place) std::erase_if(*found, [](const auto& p) { return p.passage; });
      return found;
    });
  }
  auto attempts(RunId id) const {
    return read([=](Store& store) { return store.points().attempts(id); });
  }
  auto datums(RunId id) const {
    return read([=](Store& store) { return store.points().data(id); });
  }
  auto events(EventId after, int limit) const {
    return read([=](Store& store) { return store.events().events(after, limit); });
  }
  auto promotions() const {
    return read([](Store& store) { return store.models().promotions(); });
  }
  asio::io_context& io() { return io_; }
  CellTime now() const { return time_.now().utc; }
  VirtualTime& time() { return time_; }

  void shut_down();
  const auto& halt_not_on_record() const { return halt_not_on_record_; }  // after shut_down()
  void forget() { cell_.reset(); }  // it was shut down by hand
  // Lets the world go on until the condition holds; throws when it does not within the limit of
  // cell time.
  void until(const std::function<bool()>& condition, double limit_s = 36'000);
  void pass(double seconds);
  // Lets the world go on until the call has its answer.
  template <class T>
  T await(Awaitable<T> call) {
    std::optional<T> answer;
    begin(std::move(call), answer);
    until([&answer] { return answer.has_value(); });
    return std::move(*answer);
  }

  // The same without waiting: the answer is there when the world has gone on for long enough.
  template <class T>
  void begin(Awaitable<T> call, std::optional<T>& answer) {
    asio::co_spawn(io_, std::move(call), [&answer](std::exception_ptr error, T value) {
      if (error) std::rethrow_exception(error);
      answer.emplace(std::move(value));
    });
  }

  const application::Caller ada{"ada", "ipv4:127.0.0.1:5020", {}};
  // What somebody answers who has read the question about the run under way.
  application::HoldAnswer answer(std::string override_reason = {});
  // Resumes it as this person, who has read the question.
  Result<RunRecord> resume(const application::Caller& who, std::string override_reason = {});
  Result<RunRecord> resume() { return resume(ada); }
  std::string lease();                                     // taken, or renewed
  RunRecord begin_run(const std::string& trajectory_csv);  // throws when refused
  RunRecord finish_run();                                  // until the run under way is over
  Result<RunRecord> try_run(application::CreateRun request);
  std::vector<std::string> events_named(const std::string& what);  // their details
  // Messages of the alarms of this kind that stand now.
  std::vector<std::string> alarms_of(const std::string& kind);

 private:
  asio::io_context io_;
  VirtualTime time_;
  std::unique_ptr<application::Cell> cell_;
  std::optional<formats::KeptStop> halt_not_on_record_;
  std::string lease_;
};

// "q1_mm,set,line,zero": lines of the given positions in mm, alternating calibration and
// validation.
std::string lines_of(int lines, const std::vector<double>& positions_mm, bool with_zero);

}  // namespace driftwise::tests
