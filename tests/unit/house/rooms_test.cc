// A room is a folder that a newcomer can read in an hour: few units, sub-rooms whose arrows run one
// way, and a README that says where to start. docs/architecture.md has the rooms.

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

const fs::path kTree = DRIFTWISE_SOURCE_DIR;
constexpr std::size_t kMostUnits = 20;

// The rooms of docs/architecture.md that hold sub-rooms.
const std::vector<std::string> kRoomsWithSubRooms = {"server/core",
                                                     "server/calibration",
                                                     "server/formats",
                                                     "server/application",
                                                     "server/diagnosis",
                                                     "server/rpc",
                                                     "storage",
                                                     "clients/cli",
                                                     "drivers/simulated/plant",
                                                     "drivers/simulated/emulators"};

bool is_source(const fs::path& path) {
  return path.extension() == ".h" || path.extension() == ".cc";
}

// Units (a .h with its .cc) by folder, paths relative to the top.
std::map<std::string, std::set<std::string>> units_by_folder() {
  std::map<std::string, std::set<std::string>> found;
  for (const std::string top : {"server", "drivers", "storage", "clients", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(kTree / top))
      if (is_source(entry.path()) &&
          entry.path().string().find("/node_modules/") == std::string::npos)
        found[fs::relative(entry.path().parent_path(), kTree).string()].insert(
            entry.path().stem().string());
  return found;
}

std::string sub_room_of(const std::string& room, const std::string& path) {
  const std::string inside = path.substr(room.size() + 1);
  const auto slash = inside.find('/');
  return slash == std::string::npos ? "." : inside.substr(0, slash);
}

// Which sub-rooms each sub-room of a room includes, with one example; "." is the room's own folder.
std::map<std::string, std::map<std::string, std::string>> arrows_inside(const std::string& room) {
  static const std::regex quoted(R"(^\s*#\s*include\s*"([^"]+)\")");
  std::map<std::string, std::map<std::string, std::string>> arrows;
  for (const auto& entry : fs::recursive_directory_iterator(kTree / room)) {
    if (!is_source(entry.path())) continue;
    const std::string path = fs::relative(entry.path(), kTree).string();
    std::ifstream file(entry.path());
    std::smatch match;
    for (std::string line; std::getline(file, line);) {
      if (!std::regex_search(line, match, quoted)) continue;
      const std::string included = match[1];
      if (!included.starts_with(room + "/")) continue;
      const std::string from = sub_room_of(room, path), to = sub_room_of(room, included);
      if (from != to) arrows[from].emplace(to, path + " includes " + included);
    }
  }
  return arrows;
}

TEST(Rooms, HoldAtMostTwentyUnitsPerFolder) {
  const auto folders = units_by_folder();
  ASSERT_GT(folders.size(), 40U) << "the tree was not found at " << kTree;
  for (const auto& [folder, units] : folders) {
    EXPECT_LE(units.size(), kMostUnits) << folder << " needs sub-rooms";
  }
}

// A circle is found by taking away, again and again, each sub-room that includes none that is left.
TEST(Rooms, HaveSubRoomsWhoseArrowsRunOneWay) {
  for (const auto& room : kRoomsWithSubRooms) {
    auto arrows = arrows_inside(room);
    ASSERT_FALSE(arrows.empty()) << room << " has no sub-rooms";
    for (bool taken = true; taken;) {
      taken = false;
      for (auto from = arrows.begin(); from != arrows.end();) {
        const bool free = std::ranges::none_of(
            from->second, [&](const auto& to) { return arrows.contains(to.first); });
        taken = taken || free;
        from = free ? arrows.erase(from) : std::next(from);
      }
    }
    std::string circle;
    for (const auto& [from, to] : arrows)
      for (const auto& [name, example] : to)
        if (arrows.contains(name)) circle += "\n  " + from + " -> " + name + ": " + example;
    EXPECT_TRUE(circle.empty()) << room << " has a circle of sub-rooms:" << circle;
  }
}

TEST(Rooms, SayWhatTheyAreAndWhereToStart) {
  std::vector<std::string> rooms = {"drivers", "storage", "drivers/transport",
                                    "drivers/simulated/plant", "drivers/simulated/emulators"};
  for (const std::string top : {"server", "clients"})
    for (const auto& entry : fs::directory_iterator(kTree / top))
      if (entry.is_directory()) rooms.push_back(fs::relative(entry.path(), kTree).string());
  for (const auto& room : rooms) {
    std::ifstream readme(kTree / room / "README.md");
    ASSERT_TRUE(readme) << room << " has no README.md";
    const std::string text{std::istreambuf_iterator<char>(readme), {}};
    EXPECT_TRUE(text.find("May use:") != std::string::npos)
        << room << "/README.md does not say what it may use";
    EXPECT_TRUE(text.find("Start reading:") != std::string::npos)
        << room << "/README.md does not say where to start";
    EXPECT_LE(std::ranges::count(text, '\n'), 70) << room << "/README.md is longer than a page";
    const std::string start = text.substr(text.find("Start reading:"));
    // Each file to start with exists.
    static const std::regex named(R"(`([a-z0-9_/]+\.(?:h|cc|proto|tsx?|py))`)");
    for (auto at = std::sregex_iterator(start.begin(), start.end(), named);
         at != std::sregex_iterator(); ++at)
      EXPECT_TRUE(fs::exists(kTree / room / (*at)[1].str()))
          << room << "/README.md names " << (*at)[1].str();
  }
}

}  // namespace
