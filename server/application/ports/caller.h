#pragma once
// The client behind a call.

#include <string>
#include <utility>

namespace driftwise::application {

// Passed on whole: one made anew from name and peer alone would stand in the audit as somebody who
// only states a name.
struct Caller {
  Caller() = default;  // nobody
  Caller(std::string called, std::string from, std::string proved_by)
      : name(std::move(called)), peer(std::move(from)), proof(std::move(proved_by)) {}

  std::string name, peer;  // "ada", "ipv4:127.0.0.1:5020"
  std::string proof;       // how the name is known: "token"; empty: as the client states it
};

}  // namespace driftwise::application
