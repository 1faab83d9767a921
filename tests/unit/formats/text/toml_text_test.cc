#include "server/formats/text/toml_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/formats/cell_file/cell_file.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/import/mapping_file.h"
#include "server/formats/indentation/indentation_file.h"
#include "server/formats/plan/plan_file.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;

// Levels that overflow the stack of a thread in toml++ 3.3.0.
constexpr int kFatalLevels = 32500;

std::string times(int count, const std::string& text) {
  std::string out;
  for (int i = 0; i < count; ++i) out += text;
  return out;
}

std::string dotted(int parts) { return times(parts - 1, "a.") + "a"; }

// "file:line:column: what", or "" for a text that can be read.
std::string refusal(const std::string& text) {
  try {
    parse_toml(text, "f.toml");
    return "";
  } catch (const toml::parse_error& error) {
    const auto& at = error.source();
    return *at.path + ":" + std::to_string(at.begin.line) + ":" + std::to_string(at.begin.column) +
           ": " + std::string(error.description());
  }
}

struct Deep {
  const char* name;
  std::string text;
};
class DeepToml : public testing::TestWithParam<Deep> {};
TEST_P(DeepToml, IsRefusedBeforeItOverflowsTheStack) {
  EXPECT_THAT(refusal(GetParam().text), HasSubstr("more than 100 levels inside one another"));
}
INSTANTIATE_TEST_SUITE_P(
    Table, DeepToml,
    testing::Values(
        Deep{"dotted_key", dotted(kFatalLevels) + " = 1"},
        Deep{"dotted_key_with_blanks", times(kFatalLevels, "a \t. ") + "a = 1"},
        Deep{"dotted_key_of_quoted_parts", times(kFatalLevels, "\"a.b\".'c#'.") + "a = 1"},
        Deep{"header", "[" + dotted(kFatalLevels) + "]\n"},
        Deep{"header_of_an_array", "[[" + dotted(kFatalLevels) + "]]\n"},
        Deep{"header_and_key", "[" + dotted(60) + "]\n" + dotted(60) + " = 1\n"},
        Deep{"lists", "a = " + times(kFatalLevels, "[") + times(kFatalLevels, "]")},
        Deep{"tables_in_braces", times(kFatalLevels, "a = {") + times(kFatalLevels, "}")},
        // 200 levels of values pass toml++'s own limit of 256: 20000 with their keys.
        Deep{"dotted_keys_in_braces", times(200, dotted(100) + " = {") + "a = 1" + times(200, "}")},
        Deep{"dotted_keys_in_lists",
             "a = " + times(100, "[{" + dotted(100) + " = ") + "1" + times(100, "}]")},
        Deep{"key_after_a_comment", "# it's \"open\n" + dotted(kFatalLevels) + " = 1"},
        Deep{"key_after_strings",
             "a = \"\"\"\"x\"\"\"\"\"\nb = '''it's'''''\nc = \"\\\"\"\nd = ''\ne = 'C:\\'\n[t]\n" +
                 dotted(kFatalLevels) + " = 1"},
        Deep{"key_after_a_list",
             "l = [\n  1.5, # one ] \"\n  2.5,\n]\n" + dotted(kFatalLevels) + " = 1"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(ParseToml, NamesFileLineAndColumnOfADeepKey) {
  EXPECT_THAT(refusal("a = 1\n\n" + dotted(kFatalLevels) + " = 1"),
              testing::StartsWith("f.toml:3:200: "));
}

TEST(ParseToml, ReadsToTheLimit) {
  EXPECT_EQ(refusal(dotted(100) + " = 1"), "");
  EXPECT_NE(refusal(dotted(101) + " = 1"), "");
  EXPECT_EQ(refusal("[" + dotted(50) + "]\n" + dotted(50) + " = 1"), "");
  EXPECT_NE(refusal("[" + dotted(50) + "]\n" + dotted(51) + " = 1"), "");
}

TEST(ParseToml, CountsNoDotOfATextACommentOrANumber) {
  const std::string words = times(500, "a.b.c[{ ");
  std::string text = R"(# W
"W" = "W" # W
'Wk' = 'W'
basic = """
W "" W \""" W \
  W"""""
literal = '''
W '' [x.y] # W\'''
at = 2011-07-22T08:00:00.5Z
day = 2011-07-22
clock = 08:00:00.25
)";
  for (auto at = text.find('W'); at != std::string::npos; at = text.find('W', at))
    text.replace(at, 1, words);
  const auto root = parse_toml(text + "floats = [" + times(500, "1.5,\n-2.5e-3, ") +
                               "]\ntables = [" + times(500, "{a.b = 1.5}, ") + "]\n" +
                               times(500, "[[row]]\nx.y = 1.5\nz.y = [[1.5, 2.5], [3.5, 4.5]]\n"));
  EXPECT_EQ(root.size(), 10U);
  EXPECT_EQ(root[words].value_or(std::string()), words);
  EXPECT_EQ(root[words + "k"].value_or(std::string()), words);
  EXPECT_TRUE(root["basic"].value_or(std::string()).ends_with(words + "\"\""));
  EXPECT_TRUE(root["literal"].value_or(std::string()).ends_with(words + "\\"));
  EXPECT_EQ(root["floats"].as_array()->size(), 1000U);
  EXPECT_EQ(root["tables"].as_array()->size(), 500U);
  EXPECT_EQ(root["row"].as_array()->size(), 500U);
  EXPECT_TRUE(root["at"].is_date_time());
}

TEST(ParseToml, NamesASyntaxErrorAsBefore) {
  EXPECT_THAT(refusal("a = 1\nb = [1,\n" + times(200, "c = 1.5\n")),
              testing::StartsWith("f.toml:3:"));
  EXPECT_THAT(refusal("a = \"open\n" + times(200, "c = 1.5\n")), testing::StartsWith("f.toml:1:"));
}

TEST(EveryTomlReader, RefusesDeepKeysWithFileAndLine) {
  const std::string text = "\n" + dotted(kFatalLevels) + " = 1\n";
  const auto check = [](const auto& read) {
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().reason, "TOML_SYNTAX");
    EXPECT_THAT(read.error().message, testing::StartsWith("f.toml:2: column 200: found keys"));
  };
  check(read_indentation_file(text, "f.toml"));
  check(read_plan_file(text, "f.toml"));
  check(read_import_mapping(text, "f.toml"));
  check(parse_cell_file(text, "f.toml", {}));
  check(parse_robot_file(text, "f.toml"));
}

}  // namespace
}  // namespace driftwise::formats
