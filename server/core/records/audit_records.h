#pragma once
// Acts of people on the record, and the chain that shows whether the record was changed since.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/ids.h"

namespace driftwise {

// Who did something, and how that is known.
struct Identity {
  std::string name;   // "ada"
  std::string proof;  // "stated", "peer credentials", "certificate", "token"
  std::string from;   // network address; empty: the daemon itself
};

struct AuditRecord {
  std::int64_t id = 0;
  Stamp at;
  Identity by;
  std::string what;           // dotted and stable: "model.promoted"
  std::string subject;        // "model 3"; empty: the cell
  std::string before, after;  // the value that it changed; empty: none
  std::string outcome;        // empty: done; else why it was refused
  EventId event{};            // of the same act; value 0: none
};

// The head of the chain at an entry: what leaves the machine.
struct ChainHead {
  std::int64_t entry = 0;  // 0: the chain has not begun
  std::string hash;        // SHA-256, 64 hexadecimal digits
  bool operator==(const ChainHead&) const = default;
};
std::string to_string(const ChainHead& head);  // "HASH@N"
std::optional<ChainHead> chain_head_from(const std::string& text);

struct ChainReport {
  ChainHead head;          // of the newest entry
  std::int64_t units = 0;  // a row with the rows that belong to it, compared
  std::int64_t rows = 0;   // in them
  std::int64_t differences = 0;
  std::vector<std::string> first;  // sentences on the first of them, in the order of the check
  std::int64_t thinned_readings = 0;
  std::vector<std::string> thinned;  // sentences on the first stretches that were thinned
  bool intact() const { return differences == 0; }
};

}  // namespace driftwise
