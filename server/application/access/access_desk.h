#pragma once
// The record of access: what the doors refused becomes events and alarms. One client that keeps
// trying with a wrong token is one condition, however often it tries. A certificate that is
// about to end, and a door whose address the computer does not have, are alarms. note() on any
// thread, everything else on the executor's.

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "server/access/access_witness.h"
#include "server/access/proof_ends.h"
#include "server/application/plumbing/event_log.h"
#include "server/application/plumbing/signal.h"
#include "server/application/plumbing/task_group.h"
#include "server/application/ports/alarm_condition.h"
#include "server/core/description/access_description.h"
#include "server/core/ports/clock.h"

namespace driftwise::application {

class AccessDesk final : public access::AccessWitness {
 public:
  // Between two looks at certificates and addresses, wall time.
  static constexpr double kLook_s = 60;
  // A source of wrong tokens that was silent for so long tries no more: as long as the doors
  // remember its tries (wrong_tries.h).
  static constexpr double kSilent_s = 3600;
  // Sources that are named; further ones are one condition together.
  static constexpr std::size_t kMostSources = 100;

  // texts: the thread that reads the files.
  AccessDesk(asio::any_io_executor executor, asio::any_io_executor texts,
             const AccessDescription& description, Clock& clock, EventLog& events,
             TaskGroup& tasks);

  void note(access::AccessNote what) override;
  // Ends of clients' tokens and certificates are asked here, on the thread of the texts.
  // Before start(); what it asks outlives shut_down().
  void ask_for_ends(std::function<std::vector<access::EndingProof>()> ends);

  void start();  // looks at both until shut_down()
  void shut_down();
  // certificate.ends: 30 days ahead, by the wall clock; certificate.unusable: its files cannot be
  // read or do not belong together; certificate.revocations: the list of revoked ones likewise;
  // door.unreached: the computer does not have the address; access.ends: a client's token or
  // certificate, 30 days ahead; access.wrong_tries: a source whose tokens were wrong so often that
  // it has to wait.
  std::vector<AlarmCondition> conditions() const;
  // Whether a condition of before the start was looked at since: the files and doors were, the
  // certificate was shown again, a source of wrong tokens had the time to be silent.
  bool has_judged(const std::string& kind, const std::string& subject) const;

 private:
  struct Looked {
    std::vector<AlarmCondition> conditions;
    std::set<std::string> proofs;  // subjects of access.ends that are known
  };
  struct Trying {
    std::string name, detail;  // as it calls itself, empty: not at all; of its last lock
    CellTime last;
  };
  static Looked look_at(const AccessDescription& described,
                        const std::function<std::vector<access::EndingProof>()>& ends);
  Awaitable<void> watch();
  void take(const access::AccessNote& what);
  void take_try(const access::AccessNote& what);
  bool is_silent(const Trying& one) const;

  asio::any_io_executor executor_, texts_;
  const AccessDescription& description_;
  Clock& clock_;
  EventLog& events_;
  TaskGroup& tasks_;
  std::function<std::vector<access::EndingProof>()> ends_;
  Looked looked_;
  bool has_looked_ = false;
  std::map<std::string, Trying> trying_;  // by source
  CellTime started_;
  bool ending_ = false;
  Signal ended_;
};

}  // namespace driftwise::application
