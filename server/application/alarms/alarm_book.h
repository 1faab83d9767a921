#pragma once
// Alarms that stand, each with its beginning, its end and its acknowledgement, kept in the store:
// what was acknowledged before a restart stays so, and what still holds goes on instead of
// beginning anew. What a source knows of its condition (since when a value is beyond a limit, that
// a receiver takes nothing) does not outlast the daemon, so that its silence after a start says
// nothing: an alarm of before the start ends only when its source has judged since. Executor's
// thread.

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/application/plumbing/store_writer.h"
#include "server/application/plumbing/watch_list.h"
#include "server/application/ports/alarm_condition.h"
#include "server/core/ports/clock.h"

namespace driftwise::application {

class AlarmBook {
 public:
  // A condition is over when this many looks in a row did not find it: one that flickers is one
  // alarm.
  static constexpr int kLooksToClear = 3;
  // A sentence whose numbers changed is told again no more often than this; new consequences at
  // once.
  static constexpr std::chrono::seconds kBetweenTellings{10};
  // Of those that are over at once, while the store takes nothing; the newest beyond it are logged.
  static constexpr std::size_t kMostNotes = 10'000;

  AlarmBook(Clock& clock, StoreWriter& writer) : clock_(clock), writer_(writer) {}

  // Whether the source of this alarm's condition has looked at it since the start.
  using IsJudged = std::function<bool(const AlarmRecord&)>;

  // Once, before the first look: what the store has standing.
  Awaitable<Result<void>> restore();
  // Alarms of before the start that no source has judged since: they stand.
  std::vector<AlarmRecord> unjudged() const;
  // Raises what is new and clears what is over. What the store refuses (a full disk) is kept with
  // its beginning, and its end where it has one, and tried again at every look: the alarm of the
  // full disk itself is over by the time that it can be written. Watchers hear of a beginning, a
  // change and an end when it is, not when it is stored: what the store does not have yet has id 0,
  // and is the alarm of that kind, subject and beginning when it has one. A condition that returns
  // after its end was told is another alarm. is_judged: asked of what unjudged() has and
  // conditions do not; empty: all is judged.
  Awaitable<void> look(std::vector<AlarmCondition> conditions, IsJudged is_judged = {});
  // Something that happened and is over at once: stands until it is acknowledged. Each is an alarm
  // of its own, also where the store refuses several of one kind and subject.
  Awaitable<void> note(AlarmCondition condition);
  Awaitable<Result<AlarmRecord>> acknowledge(AlarmId id, std::string who);
  Awaitable<Result<AlarmRecord>> shelve(AlarmId id, double for_s, std::string who,
                                        std::string reason);
  Awaitable<Result<AlarmRecord>> unshelve(AlarmId id);
  // Those whose time is over come back.
  Awaitable<void> end_shelves();
  // What the store has not taken yet, without an id: newest last.
  std::vector<AlarmRecord> unstored() const;
  // Of those on record: whose change or end the store has not taken yet, as they are now.
  std::vector<AlarmRecord> outdated() const;

  WatchList<AlarmRecord>& watchers() { return watchers_; }

 private:
  using Key = std::pair<std::string, std::string>;  // kind, subject
  struct Standing {
    AlarmRecord alarm;
    int looks_without = 0;
    CellTime told = {};
    bool restored = false;  // of before the start, not judged since
    bool unstored = false;  // its message: the store has another one
  };
  struct Unstored {
    AlarmRecord alarm;
    int looks_without = 0;
    CellTime told = {};
    bool is_news = true;
  };
  AlarmRecord begun(const AlarmCondition& condition) const;
  Awaitable<Result<AlarmRecord>> store(AlarmRecord alarm);
  bool keep(AlarmRecord over);  // until the store takes it; false: there are too many
  AlarmRecord publish(AlarmRecord stored);
  void publish_unstored();
  Awaitable<void> store_ends();
  Awaitable<void> tell_what_changed(const std::vector<AlarmCondition>& conditions);
  Awaitable<void> store_what_waits(const std::set<Key>& found);

  Clock& clock_;
  StoreWriter& writer_;
  std::map<Key, Standing> standing_;
  std::map<Key, Unstored> unstored_;
  std::deque<AlarmRecord> unstored_notes_;  // over already, in their order
  std::map<AlarmId, AlarmRecord> ended_;    // on record, their ends not
  WatchList<AlarmRecord> watchers_;
  CellTime next_shelf_look_;
};

}  // namespace driftwise::application
