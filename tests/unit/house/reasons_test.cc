// The table of server/core/reasons.h: complete, used, in order, and the only place that spells a
// reason.

#include "server/core/reasons.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace driftwise {
namespace {

namespace files = std::filesystem;
const files::path kTop = DRIFTWISE_SOURCE_DIR;

struct Row {
  std::string constant, name, recovery;
};

std::string text_of(const files::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::vector<Row> table() {
  static const std::regex row("inline constexpr Reason (\\w+)\\{\"(\\w+)\", Recovery::(\\w+)\\}");
  const std::string text = text_of(kTop / "server/core/reasons.h");
  std::vector<Row> rows;
  for (std::sregex_iterator hit(text.begin(), text.end(), row), end; hit != end; ++hit)
    rows.push_back({(*hit)[1], (*hit)[2], (*hit)[3]});
  return rows;
}

// The sources that make errors, without their comments. The simulated cell has no reasons: it knows
// nothing of the server.
std::map<std::string, std::string> sources() {
  std::map<std::string, std::string> found;
  for (const char* folder : {"server", "drivers", "storage"})
    for (const auto& entry : files::recursive_directory_iterator(kTop / folder)) {
      const auto path = files::relative(entry.path(), kTop).string();
      if ((!path.ends_with(".cc") && !path.ends_with(".h")) ||
          path.starts_with("drivers/simulated") || path == "server/core/reasons.h")
        continue;
      std::ifstream file(entry.path());
      std::string& text = found[path];
      for (std::string line; std::getline(file, line);) {
        const auto comment = line.find("//");
        const bool in_text =
            std::count(line.begin(),
                       line.begin() + static_cast<std::ptrdiff_t>(std::min(comment, line.size())),
                       '"') %
                2 !=
            0;
        text += (in_text ? line : line.substr(0, comment)) + "\n";
      }
    }
  return found;
}

TEST(Reasons, AreInTheOrderOfTheAlphabetAndNamedLikeTheirConstants) {
  const auto rows = table();
  EXPECT_GT(rows.size(), 300U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::string expected = "k";
    bool first = true;
    for (const char c : rows[i].name) {
      if (c == '_')
        first = true;
      else
        expected += std::exchange(first, false) ? c : static_cast<char>(std::tolower(c));
    }
    EXPECT_EQ(rows[i].constant, expected);
    if (i > 0) {
      EXPECT_LT(rows[i - 1].name, rows[i].name);
    }
  }
}

TEST(Reasons, AreSpelledInTheTableOnly) {
  std::set<std::string> names;
  for (const auto& row : table()) names.insert(row.name);
  static const std::regex literal("\"([A-Z][A-Z0-9]*(_[A-Z0-9]+)*)\"");
  static const std::regex made(
      "(ErrorCode::\\w+,\\s*|reason [!=]= )\"[A-Z][A-Z0-9]*(_[A-Z0-9]+)*\"");
  std::vector<std::string> found;
  for (const auto& [path, text] : sources()) {
    for (std::sregex_iterator hit(text.begin(), text.end(), literal), end; hit != end; ++hit)
      if (names.contains((*hit)[1])) found.push_back(path + ": " + hit->str());
    for (std::sregex_iterator hit(text.begin(), text.end(), made), end; hit != end; ++hit)
      found.push_back(path + ": " + hit->str());
  }
  EXPECT_THAT(found, testing::IsEmpty()) << "make them constants of server/core/reasons.h";
}

TEST(Reasons, AreEachMadeSomewhere) {
  static const std::regex use("reasons::(k\\w+)");
  std::set<std::string> used;
  for (const auto& [path, text] : sources())
    if (path != "server/core/reasons.cc")
      for (std::sregex_iterator hit(text.begin(), text.end(), use), end; hit != end; ++hit)
        used.insert((*hit)[1]);
  for (const auto& row : table())
    EXPECT_TRUE(used.contains(row.constant)) << row.constant << " is in the table for nothing";
}

TEST(Reasons, HaveTheRecoveryOfTheirLine) {
  const std::map<std::string, Recovery> recoveries = {
      {"by_code", Recovery::by_code},     {"leave", Recovery::leave}, {"abort", Recovery::abort},
      {"new_datum", Recovery::new_datum}, {"fail", Recovery::fail},   {"hold", Recovery::hold}};
  for (const auto& row : table())
    EXPECT_EQ(recovery_of(row.name), recoveries.at(row.recovery)) << row.name;
  EXPECT_EQ(recovery_of("MADE_ELSEWHERE"), Recovery::by_code);
}

TEST(Reasons, OfTheManualAreInTheTable) {
  std::set<std::string> names;
  for (const auto& row : table()) names.insert(row.name);
  const std::string manual = text_of(kTop / "docs/api.md");
  static const std::regex line("\n\\| [^\n|]*`[A-Z_]+`[^\n|]*\\|[^\n|]*\\|([^\n|]*)\\|");
  static const std::regex quoted("`([A-Z][A-Z0-9_]+)");
  const auto begin = manual.find("## Errors");
  ASSERT_NE(begin, std::string::npos);
  const std::string errors = manual.substr(begin, manual.find("\n## ", begin + 1) - begin);
  int checked = 0;
  for (std::sregex_iterator row(errors.begin(), errors.end(), line), end; row != end; ++row) {
    const std::string examples = (*row)[1];
    for (std::sregex_iterator hit(examples.begin(), examples.end(), quoted); hit != end; ++hit) {
      EXPECT_TRUE(names.contains((*hit)[1])) << "docs/api.md names " << (*hit)[1];
      ++checked;
    }
  }
  EXPECT_GT(checked, 10);
}

}  // namespace
}  // namespace driftwise
