#include "tests/support/cell_in_memory.h"

#include <stdlib.h>

#include <sstream>

namespace driftwise::tests {

Folder::Folder() {
  // In memory where there is such a place: these tests kill processes, not disks, and fsync is
  // slow.
  const std::filesystem::path memory = "/dev/shm";
  const auto root =
      std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
  std::string name = (root / "driftwise-XXXXXX").string();
  if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
  path_ = name;
}

Folder::~Folder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

CellInMemory::CellInMemory(SmallWorld& world, CellDescription description, OpenStore open_store,
                           CellTime begin)
    : CellInMemory(world, std::move(description), std::move(open_store), Further{.begin = begin}) {}

CellInMemory::CellInMemory(SmallWorld& world, CellDescription description, OpenStore open_store,
                           Further further)
    : CellInMemory(
          [&world](VirtualTime& time, const CellDescription& cell) {
            return small_devices(world, time, cell);
          },
          std::move(description), std::move(open_store), std::move(further)) {}

CellInMemory::CellInMemory(const MakeDevices& make_devices, CellDescription description,
                           OpenStore open_store, Further further)
    : time_(further.begin) {
  application::Cell::Parts parts;
  parts.devices = make_devices(time_, description);
  // A test that wants reports puts a template there.
  parts.report_template =
      std::filesystem::path(description.database).replace_filename("report.html").string();
  parts.description = std::move(description);
  parts.clock = std::make_unique<VirtualClock>(time_);
  parts.open_store = std::move(open_store);
  parts.version = "test";
  parts.storage_thread = parts.query_thread = parts.worker_thread = io_.get_executor();
  parts.text_thread = further.text_thread ? further.text_thread : io_.get_executor();
  parts.upkeep_thread = io_.get_executor();
  parts.diagnosis_thread = further.diagnosis_thread ? further.diagnosis_thread : io_.get_executor();
  parts.diagnose = std::move(further.diagnose);
  parts.boot_id = std::move(further.boot_id);
  parts.end_daemon = std::move(further.end_daemon);
  parts.kept_stop = std::move(further.kept_stop);
  parts.notify_threads = io_.get_executor();
  parts.notifier = std::move(further.notifier);
  auto cell = application::Cell::open(io_.get_executor(), std::move(parts));
  if (!cell) throw std::runtime_error(cell.error().message);
  cell_ = std::move(*cell);
  cell_->start();
}

CellInMemory::~CellInMemory() { shut_down(); }

void CellInMemory::shut_down() {
  if (!cell_) return;
  bool down = false;
  asio::co_spawn(io_, cell_->shut_down(), [&down](std::exception_ptr error) {
    if (error) std::rethrow_exception(error);
    down = true;
  });
  until([&down] { return down; });
  io_.restart();
  io_.poll();
  halt_not_on_record_ = cell_->halt_not_on_record();
  cell_.reset();
}

void CellInMemory::until(const std::function<bool()>& condition, double limit_s) {
  const auto limit = time_.now().utc + nanoseconds_from_s(limit_s);
  while (true) {
    io_.restart();
    while (!condition()) {
      if (io_.poll_one() == 0) break;
    }
    if (condition()) return;
    if (!time_.step())
      throw std::runtime_error("nobody has anything left to do, and the condition does not hold");
    if (time_.now().utc > limit)
      throw std::runtime_error("the condition does not hold within the limit of cell time");
  }
}

void CellInMemory::pass(double seconds) {
  bool passed = false;
  asio::co_spawn(io_, time_.sleep_until(time_.now().utc + nanoseconds_from_s(seconds)),
                 [&passed](std::exception_ptr) { passed = true; });
  until([&passed] { return passed; }, seconds + 1);
}

application::HoldAnswer CellInMemory::answer(std::string override_reason) {
  const auto run = status().run;
  return {run ? run->run.hold.id() : 0, std::move(override_reason)};
}

Result<RunRecord> CellInMemory::resume(const application::Caller& who,
                                       std::string override_reason) {
  const RunId run = status().run->run.id;
  return await(cell_->services().runs.resume(who, run, answer(std::move(override_reason))));
}

std::string CellInMemory::lease() {
  auto lease = cell_->services().manual.take_lease(ada, std::chrono::hours(1), lease_);
  if (!lease) lease = cell_->services().manual.take_lease(ada, std::chrono::hours(1), "");
  if (!lease) throw std::runtime_error(lease.error().message);
  return lease_ = lease->token;
}

Result<RunRecord> CellInMemory::try_run(application::CreateRun request) {
  if (request.lease_token.empty()) request.lease_token = lease();
  return await(cell_->services().runs.create(ada, std::move(request)));
}

RunRecord CellInMemory::begin_run(const std::string& trajectory_csv) {
  application::CreateRun request;
  request.name = "test";
  request.trajectory_name = "test.csv";
  request.trajectory_text = trajectory_csv;
  auto run = try_run(std::move(request));
  if (!run) throw std::runtime_error(run.error().message);
  return *run;
}

RunRecord CellInMemory::finish_run() {
  RunRecord last;
  const auto watch =
      cell_->services().runs.watch([&last](const application::RunProgress& p) { last = p.run; });
  until([this, &last] { return is_over(last.state) && !status().run; });
  return last;
}

std::vector<std::string> CellInMemory::events_named(const std::string& what) {
  std::vector<std::string> details;
  const auto events = await(this->events(EventId{0}, 100'000));
  if (!events) throw std::runtime_error(events.error().message);
  for (const auto& event : *events)
    if (event.what == what) details.push_back(event.detail);
  return details;
}

std::vector<std::string> CellInMemory::alarms_of(const std::string& kind) {
  std::vector<std::string> messages;
  const auto alarms = await(cell_->services().alarms.list(false, 100));
  if (!alarms) throw std::runtime_error(alarms.error().message);
  for (const auto& alarm : *alarms)
    if (alarm.kind == kind && alarm.cleared.utc_ns == 0) messages.push_back(alarm.message);
  return messages;
}

std::string lines_of(int lines, const std::vector<double>& positions_mm, bool with_zero) {
  std::ostringstream csv;
  csv << "q1_mm,set,line,zero\n";
  bool calibration = true;
  for (int line = 1; line <= lines; ++line) {
    if (with_zero) csv << "0,calibration," << line << ",1\n";
    for (const double q : positions_mm) {
      csv << q << ',' << (calibration ? "calibration" : "validation") << ',' << line << ",0\n";
      calibration = !calibration;
    }
  }
  return csv.str();
}

}  // namespace driftwise::tests
