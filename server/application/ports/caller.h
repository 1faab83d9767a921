#pragma once
// The client behind a call, as it names itself.

#include <string>

namespace driftwise::application {

struct Caller {
  std::string name, peer;
};  // "ada", "ipv4:127.0.0.1:5020": as stated, unverified until roles exist

}  // namespace driftwise::application
