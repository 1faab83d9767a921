#pragma once

#include <gmock/gmock.h>

#include <chrono>

#include "drivers/transport/link.h"
#include "tests/support/manual_clock.h"
#include "tests/support/run_awaitable.h"
#include "tests/support/scripted_peer.h"

namespace driftwise::tests {

// A driver and the other end of its line on one io_context.
class DriverFixture : public testing::Test {
 protected:
  template <class T>
  T run(Awaitable<T> work) {
    return tests::run(context, std::move(work));
  }
  // Lets everything go on that is under way, for so long.
  void let_pass(std::chrono::milliseconds time) {
    context.restart();
    context.run_for(time);
  }
  // Lets everything go on until this is so; gives up after 10 s, when the test will say what is
  // not.
  template <class Condition>
  void until(Condition condition) {
    context.restart();
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (!condition() && std::chrono::steady_clock::now() < end)
      context.run_one_for(std::chrono::milliseconds(100));
  }
  DeviceDescription device(std::string id, std::string kind) const {
    DeviceDescription out;
    out.id = std::move(id);
    out.kind = std::move(kind);
    out.address = peer.address();
    out.timeout_s = 0.25;
    return out;
  }
  void TearDown() override { EXPECT_THAT(peer.problems(), testing::IsEmpty()); }

  asio::io_context context{1};
  WallClock clock;
  ScriptedPeer peer{context};
};

}  // namespace driftwise::tests
