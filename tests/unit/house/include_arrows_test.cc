// The arrows of docs/architecture.md, kept true by reading every #include of the tree.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = DRIFTWISE_SOURCE_DIR;

const std::vector<std::string> kFixedRooms = {"server/core",
                                              "server/core/ports",
                                              "server/digest",
                                              "server/locks",
                                              "server/access",
                                              "server/effects",
                                              "server/correction",
                                              "server/kinematics",
                                              "server/plausibility",
                                              "server/identification",
                                              "server/calibration",
                                              "server/simulation",
                                              "server/diagnosis",
                                              "server/compensation",
                                              "server/plans",
                                              "server/stability",
                                              "server/standards",
                                              "server/indentation",
                                              "server/formats",
                                              "server/threads",
                                              "server/tls",
                                              "server/notify",
                                              "server/watchdog",
                                              "server/line",
                                              "server/application",
                                              "server/rpc",
                                              "server/web",
                                              "server/clean_log.h",
                                              "server/clean_log.cc",
                                              "server/controller_claim.h",
                                              "server/controller_claim.cc",
                                              "server/heap_upkeep.h",
                                              "server/heap_upkeep.cc",
                                              "server/kept_stop_file.h",
                                              "server/kept_stop_file.cc",
                                              "server/notice_file.h",
                                              "server/notice_file.cc",
                                              "server/start_warnings.h",
                                              "server/start_warnings.cc",
                                              "server/main.cc",
                                              "drivers/transport",
                                              "drivers/all_devices.h",
                                              "drivers/all_devices.cc",
                                              "drivers/simulated",
                                              "drivers/simulated/plant",
                                              "drivers/simulated/emulators",
                                              "storage",
                                              "clients/cli",
                                              "clients/cpp",
                                              "driftwise/v1"};

// One room for every device: a folder of drivers/ that is no room of another kind.
std::vector<std::string> device_rooms() {
  std::vector<std::string> rooms;
  for (const auto& entry : fs::directory_iterator(kRoot / "drivers")) {
    const std::string room = "drivers/" + entry.path().filename().string();
    if (entry.is_directory() && std::ranges::find(kFixedRooms, room) == kFixedRooms.end())
      rooms.push_back(room);
  }
  return rooms;
}

std::vector<std::string> all_rooms() {
  auto rooms = device_rooms();
  rooms.insert(rooms.end(), kFixedRooms.begin(), kFixedRooms.end());
  return rooms;
}

// The room a path belongs to: the longest of these prefixes.
const std::vector<std::string> kRooms = all_rooms();

const std::set<std::string> kMathematics = {
    "server/core",         "server/effects",        "server/correction", "server/kinematics",
    "server/calibration",  "server/identification", "server/simulation", "server/diagnosis",
    "server/compensation", "server/plans",          "server/stability",  "server/standards",
    "server/indentation"};

std::set<std::string> with(std::set<std::string> base, const std::set<std::string>& more) {
  base.insert(more.begin(), more.end());
  return base;
}

const std::set<std::string> kDomain = with(kMathematics, {"server/formats"});
// The law of every device's folder.
const std::set<std::string> kDriver = {"server/core", "server/core/ports", "server/locks",
                                       "drivers/transport"};

// What each room may include besides itself.
const std::map<std::string, std::set<std::string>> kFixedArrows = {
    {"server/core", {}},
    {"server/core/ports", {"server/core"}},
    {"server/digest", {}},
    {"server/locks", {"server/core"}},
    {"server/access", {"server/core", "server/digest"}},
    {"server/effects", {"server/core"}},
    {"server/correction", {"server/core", "server/effects"}},
    {"server/kinematics", {"server/core"}},
    {"server/plausibility", {"server/core", "server/kinematics"}},
    {"server/calibration", {"server/core", "server/effects"}},
    {"server/identification",
     {"server/core", "server/effects", "server/kinematics", "server/calibration"}},
    {"server/simulation", {"server/core", "server/effects", "server/calibration"}},
    {"server/diagnosis",
     {"server/core", "server/effects", "server/correction", "server/kinematics",
      "server/calibration", "server/identification", "server/simulation"}},
    {"server/compensation",
     {"server/core", "server/effects", "server/calibration", "server/correction",
      "server/kinematics"}},
    {"server/plans",
     {"server/core", "server/effects", "server/calibration", "server/compensation"}},
    {"server/standards", {"server/core"}},
    {"server/indentation", {"server/core"}},
    {"server/stability", {"server/core", "server/calibration"}},
    {"server/formats", with(kMathematics, {"server/digest"})},
    {"server/threads", {"server/calibration"}},
    {"server/tls", {"server/core", "server/access"}},
    {"server/notify", {"server/core", "server/core/ports"}},
    {"server/watchdog", {"server/core", "server/core/ports", "server/notify", "server/tls"}},
    {"server/line",
     {"server/core", "server/core/ports", "server/access", "server/tls", "server/compensation",
      "server/plans", "server/formats"}},
    {"server/application", with(kDomain, {"server/core/ports", "server/threads",
                                          "server/plausibility", "server/access"})},
    {"server/rpc",
     with(kDomain, {"server/core/ports", "server/application", "server/access", "driftwise/v1"})},
    {"server/web", with(kDomain, {"server/core/ports", "server/access", "server/tls",
                                  "server/application", "driftwise/v1"})},
    {"server/clean_log.h", {}},
    {"server/clean_log.cc", {"server/clean_log.h", "server/core"}},
    {"server/controller_claim.h", {"server/core", "server/locks"}},
    {"server/controller_claim.cc",
     {"server/controller_claim.h", "server/core", "server/locks", "drivers/transport"}},
    {"server/heap_upkeep.h", {"server/core"}},
    {"server/heap_upkeep.cc", {"server/heap_upkeep.h", "server/core"}},
    {"server/kept_stop_file.h", {"server/formats"}},
    {"server/kept_stop_file.cc", {"server/kept_stop_file.h", "server/core", "server/formats"}},
    {"server/notice_file.h", {}},
    {"server/notice_file.cc", {"server/notice_file.h"}},
    {"server/start_warnings.h", {"server/core"}},
    {"server/start_warnings.cc", {"server/start_warnings.h", "server/access", "server/notify"}},
    {"server/main.cc", std::set<std::string>(kRooms.begin(), kRooms.end())},
    {"drivers/transport", {"server/core", "server/core/ports"}},
    {"drivers/all_devices.h", {"server/core"}},
    {"drivers/all_devices.cc", {"drivers/all_devices.h", "server/core"}},
    {"drivers/simulated/plant", {}},
    {"drivers/simulated/emulators", {"drivers/simulated/plant"}},
    {"drivers/simulated", {"drivers/simulated/plant", "drivers/simulated/emulators"}},
    {"storage", {"server/core", "server/core/ports", "server/digest", "server/locks"}},
    {"clients/cli",
     with(kDomain, {"server/core/ports", "server/threads", "driftwise/v1", "clients/cpp", "storage",
                    "server/notify", "server/watchdog", "server/tls"})},
    {"clients/cpp", {"driftwise/v1"}},
};

std::map<std::string, std::set<std::string>> all_arrows() {
  auto arrows = kFixedArrows;
  for (const auto& room : device_rooms()) arrows.emplace(room, kDriver);
  return arrows;
}
const std::map<std::string, std::set<std::string>> kArrows = all_arrows();

std::string room_of(const std::string& path) {
  std::string best;
  for (const auto& room : kRooms)
    if (path.starts_with(room) && (path.size() == room.size() || path[room.size()] == '/') &&
        room.size() > best.size())
      best = room;
  return best;
}

struct Include {
  std::string file, included;
  int line;
  bool quoted;
};

std::vector<Include> includes_of_the_tree() {
  std::vector<Include> found;
  static const std::regex pattern(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  for (const std::string top : {"server", "drivers", "storage", "clients"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / top)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cc") continue;
      std::ifstream file(entry.path());
      std::string text;
      for (int line = 1; std::getline(file, text); ++line) {
        std::smatch match;
        if (std::regex_search(text, match, pattern))
          found.push_back(
              {fs::relative(entry.path(), kRoot).string(), match[2], line, match[1] == "\""});
      }
    }
  }
  return found;
}

TEST(IncludeArrows, PointOneWay) {
  const auto includes = includes_of_the_tree();
  ASSERT_GT(includes.size(), 100U) << "the tree was not found at " << kRoot;
  for (const auto& include : includes) {
    const std::string from = room_of(include.file), to = room_of(include.included);
    if (to.empty() || from == to) continue;
    const auto arrows = kArrows.find(from);
    ASSERT_NE(arrows, kArrows.end())
        << include.file
        << " stands in no room this test knows: add it here and to docs/architecture.md";
    EXPECT_TRUE(arrows->second.contains(to))
        << include.file << ":" << include.line << " includes " << include.included << ", but "
        << from << " may not know " << to;
  }
}

TEST(IncludeArrows, MathematicsDoNoInputOrOutputAndStartNoThread) {
  static const std::set<std::string> forbidden = {
      "thread",     "mutex",     "fstream", "iostream",
      "filesystem", "sqlite3.h", "future",  "condition_variable"};
  for (const auto& include : includes_of_the_tree()) {
    if (!kMathematics.contains(room_of(include.file))) continue;
    EXPECT_FALSE(forbidden.contains(include.included) ||
                 include.included.starts_with("boost/asio") ||
                 include.included.starts_with("grpcpp/"))
        << include.file << ":" << include.line << " includes " << include.included;
  }
}

TEST(IncludeArrows, OnlyTheAdaptersKnowGrpc) {
  for (const auto& include : includes_of_the_tree()) {
    if (!include.included.starts_with("grpc")) continue;
    const std::string room = room_of(include.file);
    EXPECT_TRUE(room == "server/rpc" || room == "server/web" || room == "server/main.cc" ||
                room.starts_with("clients/"))
        << include.file << ":" << include.line << " includes " << include.included;
  }
}

TEST(IncludeArrows, QuotedIncludesStartAtTheTop) {
  for (const auto& include : includes_of_the_tree()) {
    if (!include.quoted) continue;
    EXPECT_NE(include.included.find('/'), std::string::npos)
        << include.file << ":" << include.line << " includes " << include.included;
  }
}

TEST(TopLevel, HoldsTheHouseAndTheUsualSingleFiles) {
  static const std::set<std::string> known = {
      "CMakeLists.txt",    "proto",   "server",  "clients",
      "drivers",           "storage", "tests",   "deploy",
      "README.md",         "docs",    "LICENSE", "CHANGELOG.md",
      "CMakePresets.json", "build",   "out"};
  for (const auto& entry : fs::directory_iterator(kRoot)) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(name.starts_with(".") || known.contains(name))
        << name << " does not belong at the top level";
  }
}

}  // namespace
