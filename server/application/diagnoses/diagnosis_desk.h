#pragma once
// The diagnoses under way: on a thread of their own, so that a long one never delays a fit; one
// after the other, so that they do not delay each other.
//
// A cancelled one is over at once, on record and for its watchers, whatever its thread still does:
// the search looks at its flag every 100 ms at least, and what it says after that is not heard.
// An end that the database does not take (a full disk) is tried again until it does or the daemon
// ends; until then the diagnosis is under way, and says what it waits for.
// Executor's thread; a job's step and flag are what the worker shares with it.

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <map>
#include <memory>

#include "server/application/diagnoses/diagnosis_progress.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/plumbing/watch_list.h"
#include "server/formats/diagnosis/robot_names.h"

namespace driftwise::application {

class DiagnosisDesk {
 public:
  static constexpr std::size_t kMostAtOnce = 8;  // under way or waiting for the one before

  DiagnosisDesk(asio::any_io_executor executor, asio::any_io_executor worker, Clock& clock,
                StoreWriter& writer, EventLog& events, TaskGroup& tasks, Diagnose diagnose);
  ~DiagnosisDesk();

  // Stores it as running and begins. robot: whose part of the dataset is looked at, "" of a cell
  // with one; the options are in its bare names, what is found is stored with its id
  // (formats::RobotNames). Errors: resource_exhausted TOO_MANY_DIAGNOSES; those of
  // DiagnosisStore::add_diagnosis.
  Awaitable<Result<DiagnosisRecord>> begin(const Caller& caller, DiagnosisRecord wanted,
                                           std::shared_ptr<const Dataset> dataset,
                                           diagnosis::DiagnoseOptions options,
                                           std::string robot = {});
  // Does nothing to one that is over. Errors: of the database that does not take an end; it is
  // tried again by itself.
  Awaitable<Result<void>> cancel(const Caller& caller, DiagnosisId id);

  // Where those under way stand.
  void tell_present(const std::function<void(const DiagnosisProgress&)>& to) const;
  WatchList<DiagnosisProgress>& watchers() { return watchers_; }
  // Those under way fail with the reason that the daemon ends.
  void shut_down();

 private:
  struct Job;
  Awaitable<void> carry_out(std::shared_ptr<Job> job, std::shared_ptr<const Dataset> dataset,
                            diagnosis::DiagnoseOptions options, formats::RobotNames names);
  struct Ending;
  Awaitable<Result<void>> end(std::shared_ptr<Job> job, Ending last);
  Awaitable<void> store_later(std::shared_ptr<Job> job, Ending last);
  Awaitable<void> sleep_until_due(Job& job);
  Ending not_storable(const Job& job) const;
  static std::string waits_to_be_stored(const Job& job, const Ending& last);
  void close(Job& job, const Ending& last, bool stored);
  void heard(Job& job, double fraction, const std::string& step);

  asio::any_io_executor executor_, worker_;
  Clock& clock_;
  StoreWriter& writer_;
  EventLog& events_;
  TaskGroup& tasks_;
  Diagnose diagnose_;
  std::map<DiagnosisId, std::shared_ptr<Job>> jobs_;
  WatchList<DiagnosisProgress> watchers_;
  bool ending_ = false;
};

// What came of one, for the record: "diagnosis 3 found thermal_lag t07, backlash q1".
std::string outcome_sentence(DiagnosisId id, const diagnosis::Diagnosis& found);

}  // namespace driftwise::application
