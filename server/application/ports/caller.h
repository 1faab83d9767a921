#pragma once
// The client behind a call.

#include <string>

namespace driftwise::application {

struct Caller {
  std::string name, peer;  // "ada", "ipv4:127.0.0.1:5020"
  std::string proof = {};  // how the name is known: "token"; empty: as the client states it
};

}  // namespace driftwise::application
