// Interfaces stay small: at most eight pure virtual functions in one class, counted by reading the
// headers of these rooms.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

constexpr int kMostFunctions = 8;
const std::vector<std::string> kRoomsOfInterfaces = {"server", "storage", "drivers"};

// Older than this rule. The store's ports are asked through AsyncStore (plumbing/async_store.h);
// Store itself only names its parts.
const std::set<std::string> kLarger = {"server/core/ports/store.h RunStore",
                                       "server/core/ports/store.h DiagnosisStore",
                                       "server/core/ports/store.h Store"};

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
  for (const auto& [name, count] : counts) {
    if (kLarger.contains(name)) continue;
    EXPECT_LE(count, kMostFunctions) << name;
  }
}

TEST(InterfaceSize, NamesNoClassAsLargerThatIsNot) {
  const auto counts = pure_virtual_functions();
  for (const auto& name : kLarger)
    EXPECT_TRUE(counts.contains(name) && counts.at(name) > kMostFunctions) << name;
}

}  // namespace
