#include "server/core/text/utf8.h"

#include <gtest/gtest.h>

namespace driftwise {
namespace {

TEST(FirstBadUtf8, IsNowhereInText) {
  EXPECT_EQ(first_bad_utf8(""), std::nullopt);
  EXPECT_EQ(first_bad_utf8("x_mm\n1.5\n"), std::nullopt);
  EXPECT_EQ(first_bad_utf8("Z\xc3\xbcrich \xe6\xb5\x8b \xf0\x9f\x98\x80"), std::nullopt);
}

// Malformed forms after the Unicode standard, table 3-7 (well-formed UTF-8 byte sequences).
TEST(FirstBadUtf8, IsTheByteThatBelongsToNoCharacter) {
  EXPECT_EQ(first_bad_utf8("ab\xff"), 2u);
  EXPECT_EQ(first_bad_utf8("\xc3\xbc\x80"), 2u);
  EXPECT_EQ(first_bad_utf8("a\xc0\xaf"), 1u) << "overlong";
  EXPECT_EQ(first_bad_utf8("\xe0\x80\xaf"), 0u) << "overlong";
  EXPECT_EQ(first_bad_utf8("\xed\xa0\x80"), 0u) << "a surrogate";
  EXPECT_EQ(first_bad_utf8("\xf4\x90\x80\x80"), 0u) << "beyond U+10FFFF";
  EXPECT_EQ(first_bad_utf8("a\xe6\xb5"), 1u) << "cut short";
}

TEST(WithBadUtf8Replaced, MarksEachSuchByteAndKeepsTheRest) {
  EXPECT_EQ(with_bad_utf8_replaced("\xff"
                                   "a\xc3\xbc\xc3"),
            "?a\xc3\xbc?");
}

}  // namespace
}  // namespace driftwise
