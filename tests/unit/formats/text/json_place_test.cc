#include "server/formats/text/json_place.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/formats/indentation/procedure_json.h"
#include "server/formats/model/model_json.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;

// Levels whose copy or text overflows the stack in nlohmann::json.
constexpr std::size_t kFatal = 100000;

std::string lists(std::size_t levels) {
  return std::string(levels, '[') + std::string(levels, ']');
}

TEST(ParseJson, ReadsToTheLimitAndRefusesDeeperTextWithItsPlace) {
  EXPECT_TRUE(parse_json(lists(kMostJsonLevels)));
  EXPECT_TRUE(parse_ordered_json(lists(kMostJsonLevels)));
  for (const std::size_t levels : {kMostJsonLevels + 1, kFatal}) {
    const auto read = parse_json("{\"a\":\n" + lists(levels) + "}");
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().reason, "JSON_SYNTAX");
    EXPECT_THAT(read.error().message,
                testing::StartsWith("line 2, column 100: found more than 100 lists and objects"));
  }
  std::string objects;
  for (std::size_t level = 0; level < kFatal; ++level) objects += "{\"a\":";
  EXPECT_THAT(parse_ordered_json(objects).error().message, HasSubstr("more than 100"));
}

TEST(ParseJson, CountsNoBracketOfAText) {
  const auto read = parse_json(R"({"a\"[{": "\\", "b": ")" + std::string(500, '[') + R"(\"{"})");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ((*read)["b"], std::string(500, '[') + "\"{");
}

TEST(ParseJson, CountsListsAfterOneAnotherOnce) {
  std::string text = "[[]";
  for (int i = 0; i < 500; ++i) text += ", [{}]";
  EXPECT_TRUE(parse_json(text + "]"));
}

TEST(ParseJson, NamesANumberBeyondDoubles) {
  EXPECT_THAT(parse_json("[1e999]").error().message, HasSubstr("a number beyond doubles"));
}

TEST(ParseJson, KeepsTheOrderOfKeysWhenAsked) {
  EXPECT_EQ(parse_ordered_json(R"({"z":1,"a":2})")->dump(), R"({"z":1,"a":2})");
  EXPECT_EQ(parse_json(R"({"z":1,"a":2})")->dump(), R"({"a":2,"z":1})");
}

TEST(ReadModelJson, RefusesADeepTextAlsoForItsHash) {
  const std::string text = R"({"schema": "driftwise.model.v1", "warnings": )" + lists(kFatal) + "}";
  EXPECT_THAT(read_model_json(text).error().message, HasSubstr("more than 100 lists"));
  EXPECT_EQ(stored_model_hash(text, "").error().reason, "BAD_MODEL");
}

}  // namespace
}  // namespace driftwise::formats
