#pragma once
// Witness of the access room: refusals and wrong tries, for the record and the alarms.

#include <cstdint>
#include <string>

namespace driftwise::access {

struct AccessNote {
  enum class Kind : std::uint8_t {
    refused,       // a known identity, its role is too low
    wrong_try,     // a token that is none, or no proof at all where one is needed
    locked,        // too many wrong tries from there: nothing is looked at for a while
    token_made,    // by an admin
    token_revoked  //
  };
  Kind kind = Kind::refused;
  std::string who, from;  // name as known or as claimed; cleaned
  std::string detail;     // a sentence
  std::int64_t count =
      1;  // how many since the last note of this kind from there, this one included
  std::string proof = {};  // how the name is known: "certificate"; empty: as it is claimed
  std::string act = {};    // what was asked for: "Home", "ask for targets"; empty: nothing yet
};

// Implemented by the application, which writes an event and raises an alarm.
class AccessWitness {
 public:
  virtual ~AccessWitness() = default;
  // On any thread; returns at once.
  virtual void note(AccessNote what) = 0;
};

// "access.refused", "access.wrong_try", "access.locked", "access.token_made",
// "access.token_revoked": the event's name.
std::string to_event(AccessNote::Kind kind);

}  // namespace driftwise::access
