#include "server/formats/import/foreign_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace driftwise::formats {
namespace {

using testing::ElementsAre;
using Table = std::vector<std::vector<std::string>>;

Table table_of(std::string_view text, const TableLayout& layout, std::string* error = nullptr) {
  const std::string name = "lab.txt";
  ForeignRows rows(text, layout, name);
  Table out;
  while (rows.next()) out.push_back(rows.fields());
  if (error) *error = rows.error() ? rows.error()->message : "";
  return out;
}

TEST(ForeignRows, PartsFieldsByTheSeparatorAndTakesBlanksOff) {
  EXPECT_THAT(
      table_of("a; b ;c\r\n1;;3\n;;\n", {.separator = ';'}),
      ElementsAre(ElementsAre("a", "b", "c"), ElementsAre("1", "", "3"), ElementsAre("", "", "")));
}

TEST(ForeignRows, TakesAnyNumberOfBlanksForOne) {
  EXPECT_THAT(table_of("  a   b\tc  \n1 2 3", {.blanks_separate = true}),
              ElementsAre(ElementsAre("a", "b", "c"), ElementsAre("1", "2", "3")));
}

TEST(ForeignRows, KeepsTheFieldsBetweenTabs) {
  EXPECT_THAT(table_of("a\t\tc\n", {.separator = '\t'}), ElementsAre(ElementsAre("a", "", "c")));
}

TEST(ForeignRows, ReadsQuotedFields) {
  EXPECT_THAT(table_of("\"a,b\", \"say \"\"no\"\"\" ,c\n", {}),
              ElementsAre(ElementsAre("a,b", "say \"no\"", "c")));
  EXPECT_THAT(table_of("5\" tube,\"\n", {.quotes = false}),
              ElementsAre(ElementsAre("5\" tube", "\"")));
}

TEST(ForeignRows, PassesOverEmptyLinesCommentsAndTheFirstLines) {
  EXPECT_THAT(
      table_of("made by X\n!!\n% note\n\na,b\n% more\n1,2\n", {.comment = "%", .skip_lines = 2}),
      ElementsAre(ElementsAre("a", "b"), ElementsAre("1", "2")));
}

TEST(ForeignRows, CountsLinesForEveryKindOfLineEnd) {
  const std::string name = "lab.txt", text = "a\rb\r\n\r\nc\nd";
  const TableLayout layout;
  ForeignRows rows(text, layout, name);
  std::vector<std::size_t> lines;
  while (rows.next()) lines.push_back(rows.line());
  EXPECT_THAT(lines, ElementsAre(1, 2, 4, 5));
}

TEST(ForeignRows, RefusesAnOpenQuoteByItsLine) {
  std::string error;
  table_of("a,b\n1,\"2\n3,4\n", {}, &error);
  EXPECT_THAT(error, testing::StartsWith("lab.txt:2: field 2: found no closing quote"));
  table_of("\"a\"b,c\n", {}, &error);
  EXPECT_THAT(error, testing::HasSubstr("found 'b,c' after the closing quote"));
}

// Whatever fields hold, a table that quotes them is read as it was.
TEST(ForeignRows, ReadsBackAnyQuotedTable) {
  std::mt19937 random(9283);
  const std::string letters = "ab ,;\t\"#1.-";
  for (int i = 0; i < 500; ++i) {
    Table table(1 + random() % 4);
    const std::size_t width = 1 + random() % 5;
    std::string text;
    for (auto& row : table) {
      for (std::size_t c = 0; c < width; ++c) {
        std::string field;
        for (auto n = random() % 6; n > 0; --n) field += letters[random() % letters.size()];
        row.push_back(field);
        text += c == 0 ? "\"" : ",\"";
        for (const char letter : field) text += letter == '"' ? "\"\"" : std::string(1, letter);
        text += '"';
      }
      text += random() % 2 ? "\n" : "\r\n";
    }
    EXPECT_EQ(table_of(text, {.comment = ""}), table) << text;
  }
}

}  // namespace
}  // namespace driftwise::formats
