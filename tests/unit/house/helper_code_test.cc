// Idioms that have one helper each, kept at zero by reading the sources of the tree.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

namespace {

namespace files = std::filesystem;

struct SourceText {
  std::string path;  // below the top folder
  std::string text;
};

std::vector<SourceText> source_texts(const std::vector<std::string>& folders) {
  std::vector<SourceText> found;
  const files::path top = DRIFTWISE_SOURCE_DIR;
  for (const auto& folder : folders)
    for (const auto& entry : files::recursive_directory_iterator(top / folder)) {
      if (entry.path().extension() != ".cc" && entry.path().extension() != ".h") continue;
      std::ifstream file(entry.path());
      found.push_back({files::relative(entry.path(), top).string(),
                       {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}});
    }
  return found;
}

// "server/rpc/x.cc:12: <the match>" for each match of the pattern.
std::vector<std::string> matches(const std::vector<std::string>& folders, const char* pattern) {
  const std::regex wanted(pattern);
  std::vector<std::string> found;
  for (const auto& source : source_texts(folders))
    for (std::sregex_iterator hit(source.text.begin(), source.text.end(), wanted), end; hit != end;
         ++hit) {
      const auto line =
          std::count(source.text.begin(), source.text.begin() + hit->position(), '\n') + 1;
      found.push_back(source.path + ":" + std::to_string(line) + ": " + hit->str());
    }
  return found;
}

TEST(HelperCode, ErrorsArePassedOnByMacro) {
  // server/core/try.h: DRIFTWISE_TRY and DRIFTWISE_RETURN_IF_ERROR
  EXPECT_THAT(matches({"server", "drivers", "storage", "clients", "tests"},
                      "!(\\w+)\\)\\s*\\{?\\s*(co_)?return tl::unexpected\\(\\1\\.error\\(\\)\\);"),
              testing::IsEmpty());
}

TEST(HelperCode, TasksAreStartedBySpawnAndCountedByTheirGroup) {
  // server/core/ports/spawn.h, server/application/plumbing/task_group.h
  const std::vector<std::string> everywhere = {"server", "drivers", "storage", "clients", "tests"};
  EXPECT_THAT(matches(everywhere, "asio::detach[e]d"), testing::IsEmpty());
  EXPECT_THAT(matches({"server", "drivers", "storage"}, "\\btasks_?\\.(begin|end)\\(\\)"),
              testing::IsEmpty());
  // A completion that only throws is spawn().
  EXPECT_THAT(
      matches(
          {"server", "drivers", "storage"},
          "exception_ptr&? \\w+\\) \\{\\s*if \\((\\w+)\\) std::rethrow_exception\\(\\1\\);\\s*\\}"),
      testing::ElementsAre(testing::StartsWith("server/core/ports/spawn.h")));
}

TEST(HelperCode, OneClassIsTheMutexOfCoroutines) {
  // server/core/ports/async_mutex.h
  EXPECT_THAT(matches({"server", "drivers", "storage"}, "class (Turn|\\w*Mutex)\\b(?! *;)"),
              testing::ElementsAre(testing::StartsWith("server/core/ports/async_mutex.h")));
}

TEST(HelperCode, CallsOfTheStoreAndOfOtherThreadsAreOneStatement) {
  // server/application/plumbing/async_store.h, run_on.h: what a call owns is an argument
  EXPECT_THAT(
      matches({"server"}, "auto \\w+ =\\s*([\\w:]*run_on|[\\w.>()-]*(\\.|->)call)\\("),
      testing::ElementsAre(testing::StartsWith("server/application/plumbing/async_store.h")));
}

TEST(HelperCode, TomlIsParsedWithALimitOnItsDepth) {
  // server/formats/text/toml_text.h
  EXPECT_THAT(matches({"server", "storage", "clients"}, "\\btoml::parse(_file)?\\("),
              testing::Each(testing::StartsWith("server/formats/text/toml_text.")));
}

}  // namespace
