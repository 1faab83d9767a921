#pragma once
// A shipped cell at work, on its plant, in memory: a run that goes on and on, and one lie after the
// other told in the middle of a line.

#include <memory>
#include <string>
#include <vector>

#include "tests/faults/lies/lie_kinds.h"
#include "tests/support/cell_in_memory.h"

namespace driftwise::lies {

struct Episode {
  bool detected = false;
  double after_s = 0;          // cell time, from the first false answer that was possible to see
  bool after_closure = false;  // the next closure had not shown it
  std::string how;             // kind of the alarm: "reading.step"
  bool alarmed = false;        // it stood in the list of alarms
  bool alarm_stays = false;    // it stood although the lie was over
  int false_rows = 0;          // accepted rows with a value that is not the truth
  int unmarked_rows = 0;       // ... of these: not suspect
  int suspect_rows = 0;
  bool waited = false;   // the run was waiting at some time of the lie
  bool went_on = false;  // rows were accepted after it
  std::string said;      // the first sentence
};

class LieBench {
 public:
  explicit LieBench(const std::string& cell, std::uint64_t seed = 1);
  ~LieBench();

  const CellDescription& description() const { return description_; }
  const std::vector<ChannelOfCell>& channels() const { return channels_; }
  std::string why_not(const ChannelOfCell& channel, Kind kind) const {
    return lies::why_not(world_, description_, channel, kind);
  }
  double truth(const std::string& channel) const { return world_.liar.truth(channel); }

  Episode tell(const ChannelOfCell& channel, Kind kind, double size);
  // Lines without any lie. Every alarm that was raised, as "kind: message".
  std::vector<std::string> tell_the_truth(int lines);

 private:
  void begin_run();
  void come_to_mid_line();
  void look_at_rows(const ChannelOfCell& channel, CellTime from, Episode& episode);
  std::vector<AlarmRecord> alarms_since(CellTime since);
  int closures() const;
  std::int64_t rows_decided() const;

  tests::Folder folder_;
  CellDescription description_;
  std::vector<ChannelOfCell> channels_;
  tests::PlantWorld world_;
  std::unique_ptr<tests::CellInMemory> cell_;
  std::vector<EventRecord> events_;
  std::optional<application::RunProgress> progress_;
  std::vector<std::shared_ptr<void>> watches_;
  std::optional<RunId> run_;
};

}  // namespace driftwise::lies
