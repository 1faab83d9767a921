#pragma once
// The cell file in force, its difference to the one before, and the question that a change puts.
// Opened on the writing store before anybody is answered; afterwards the executor's thread.

#include <string>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/ports/store.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::application {

class ConfigurationBook {
 public:
  // Stores the start. Compared with the last configuration that puts no question. Errors: the
  // store's.
  static Result<ConfigurationBook> open(Store& writing, const CellDescription& cell,
                                        const std::string& version, Stamp now);

  const ConfigurationStart& start() const { return start_; }
  const std::vector<formats::ConfigurationChange>& changes() const { return changes_; }
  bool asks() const { return start_.is_open(); }
  // A sentence with the first differences and what to do; empty: no question.
  std::string question() const;
  // Why a run that was begun under another cell file may not continue; empty: it may.
  std::string question_for(const RunRecord& run) const;
  // What happened at this start, for the event.
  std::string event() const;
  // Those of the open question's changes that touch one of these symbols, as a list for people;
  // empty: none does, or nothing is open.
  std::string changes_of(const std::vector<std::string>& symbols) const;
  void answered(ConfigurationStart start) { start_ = std::move(start); }

 private:
  ConfigurationStart start_;
  std::vector<formats::ConfigurationChange> changes_;
};

// "probe t07_degC: input 107 -> 108; probe t08_degC: input 108 -> 107; and 3 more"
std::string list_of(const std::vector<formats::ConfigurationChange>& changes, std::size_t most);
// Those that ask and touch one of the symbols.
std::vector<formats::ConfigurationChange> touching(
    const std::vector<formats::ConfigurationChange>& changes,
    const std::vector<std::string>& symbols);

}  // namespace driftwise::application
