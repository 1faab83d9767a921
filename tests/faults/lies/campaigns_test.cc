// The shipped campaigns on true devices: no value is rejected, no row is marked, no alarm of a lie
// is raised.

#include <gtest/gtest.h>

#include <iostream>

#include "server/application/alarms/alarms.h"
#include "storage/sqlite_store.h"
#include "tests/support/cell_in_memory.h"
#include "tests/support/plant_cell.h"

namespace driftwise::lies {
namespace {

void expect_nothing_rejected(const std::string& cell) {
  tests::Folder folder;
  auto world = tests::make_plant_world(cell, tests::kWorldBegin, 1, false);
  const auto description = tests::shipped_cell(cell, folder / "cell.db");
  tests::CellInMemory in_memory(
      [&world](tests::VirtualTime& time, const CellDescription& described) {
        return tests::plant_devices(world, time, described);
      },
      description,
      [](const std::string& path, bool read_only) {
        return storage::open_sqlite_store(path, read_only);
      },
      tests::CellInMemory::Further{});
  std::vector<std::string> troubles;
  const auto watch = in_memory->feeds.watch_events([&troubles](const EventRecord& event) {
    for (const char* what :
         {"reading.", "pose.", "readback.", "closure.", "data.suspect", "run.trouble"})
      if (event.what.starts_with(what)) troubles.push_back(event.what + ": " + event.detail);
  });
  const auto run = in_memory.begin_run(tests::shipped_trajectory(cell));
  application::RunProgress last;
  const auto progress =
      in_memory->runs.watch([&last](const application::RunProgress& p) { last = p; });
  in_memory.until([&] { return is_over(last.run.state); }, 40 * 3600);
  EXPECT_EQ(last.run.state, RunState::done) << last.run.reason;
  EXPECT_EQ(troubles, std::vector<std::string>{});
  const auto state = in_memory.await(in_memory->annotations.exclusions(run.id));
  ASSERT_TRUE(state);
  EXPECT_TRUE(state->suspect_rows.empty());
  const auto attempts = in_memory.await(in_memory.attempts(run.id));
  ASSERT_TRUE(attempts);
  int by_readback = 0;
  for (const auto& attempt : *attempts) by_readback += attempt.reason.starts_with("the readback");
  EXPECT_EQ(by_readback, 0);
  std::cout << cell << ": " << last.run.accepted << " of " << last.run.rows << " rows accepted, "
            << last.run.given_up << " given up by the spread gate, " << last.run.attempts
            << " attempts\n";
}

TEST(Campaigns, LinearAxisIsTrusted) { expect_nothing_rejected("linear-axis"); }
TEST(Campaigns, MicroNanoIsTrusted) { expect_nothing_rejected("micro-nano"); }

}  // namespace
}  // namespace driftwise::lies
