// The list of server/core/records/alarm_kinds.h: in order, complete, used, and told in
// docs/alarms.md.

#include "server/core/records/alarm_kinds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

namespace driftwise {
namespace {

namespace files = std::filesystem;
const files::path kTopFolder = DRIFTWISE_SOURCE_DIR;

std::string file_text(const files::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string server_sources() {
  std::string all;
  for (const auto& entry : files::recursive_directory_iterator(kTopFolder / "server")) {
    const auto extension = entry.path().extension();
    if ((extension == ".cc" || extension == ".h") && entry.path().filename() != "alarm_kinds.h" &&
        entry.path().string().find("/watchdog/") == std::string::npos)
      all += file_text(entry.path());
  }
  return all;
}

TEST(AlarmKinds, AreInOrder) { EXPECT_TRUE(std::ranges::is_sorted(kAlarmKinds)); }

TEST(AlarmKinds, HoldEveryKindThatAnAlarmIsRaisedWith) {
  // {AlarmLevel::warning, "clock.behind", ... and {.level = ..., .kind = "device.lost".
  static const std::regex raised(
      R"re((?:AlarmLevel::\w+,\s*(?:\w+\s*\?\s*)?|\.kind = )"([a-z]+\.[a-z_]+)"(?:\s*:\s*"([a-z]+\.[a-z_]+)")?)re");
  const std::string text = server_sources();
  std::set<std::string> found;
  for (std::sregex_iterator hit(text.begin(), text.end(), raised), end; hit != end; ++hit)
    for (const auto& kind : {(*hit)[1].str(), (*hit)[2].str()})
      if (!kind.empty()) found.insert(kind);
  EXPECT_GT(found.size(), 30u);
  found.erase("notify.test");  // of `notify test NAME`, which asks no route
  for (const auto& kind : found) EXPECT_THAT(kAlarmKinds, testing::Contains(kind));
}

TEST(AlarmKinds, AreAllRaisedAndAllInThePageOnAlarms) {
  const std::string text = server_sources(), page = file_text(kTopFolder / "docs/alarms.md");
  for (const auto kind : kAlarmKinds) {
    // "reading." and the name of the test that failed (server/plausibility/value_judge.h).
    const bool is_test = kind.starts_with("reading.");
    const std::string spelled = "\"" + std::string(is_test ? kind.substr(8) : kind) + "\"";
    EXPECT_THAT(text, testing::HasSubstr(spelled));
    EXPECT_THAT(page, testing::HasSubstr("`" + std::string(kind) + "`"));
  }
}

}  // namespace
}  // namespace driftwise
