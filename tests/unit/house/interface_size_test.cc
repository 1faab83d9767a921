// Interfaces stay small: at most eight pure virtual functions in one class, counted by reading the
// headers of these rooms.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <string>
#include <vector>

namespace {

constexpr int kMostFunctions = 8;
const std::vector<std::string> kRoomsOfInterfaces = {"server", "storage", "drivers"};

// Pure virtual functions by class, "server/x.h Name": those between the class's head and the brace
// that ends it.
std::map<std::string, int> pure_virtual_functions() {
  static const std::regex head(R"(^(?:class|struct) (\w+)[^;]*\{)"), pure(R"(=\s*0;)");
  std::map<std::string, int> counts;
  const std::filesystem::path top = DRIFTWISE_SOURCE_DIR;
  for (const auto& room : kRoomsOfInterfaces)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(top / room)) {
      if (entry.path().extension() != ".h") continue;
      std::ifstream file(entry.path());
      std::string name;
      for (std::string line; std::getline(file, line);) {
        std::smatch match;
        if (std::regex_search(line, match, head)) {
          name = std::filesystem::relative(entry.path(), top).string() + " " + match[1].str();
        } else if (line.starts_with("};")) {
          name.clear();
        } else if (!name.empty() && std::regex_search(line, pure) &&
                   line.find(" operator") == std::string::npos && line.find('(') != line.npos) {
          ++counts[name];
        } else if (!name.empty() && line.ends_with(") = 0;")) {
          ++counts[name];
        }
      }
    }
  return counts;
}

TEST(InterfaceSize, IsEightFunctionsAtMost) {
  const auto counts = pure_virtual_functions();
  ASSERT_GT(counts.size(), 20U);
  for (const auto& [name, count] : counts) EXPECT_LE(count, kMostFunctions) << name;
}

}  // namespace
