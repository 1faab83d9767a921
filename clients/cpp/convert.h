#pragma once
// Messages of the API <-> the library's own types.

#include "clients/cpp/include/driftwise/client.h"
#include "driftwise/v1/target_service.pb.h"

namespace driftwise::client {

Target target_from(const v1::Target& message);

template <class Request>
void put_pose(const Pose& pose, Request& request) {
  for (const auto& [channel, value] : pose) {
    auto& one = *request.add_pose();
    one.set_channel(channel);
    one.set_value(value);
  }
}

}  // namespace driftwise::client
