#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <random>

#include "server/formats/text/gzip.h"
#include "server/formats/text/text_encoding.h"
#include "tests/unit/formats/import/gzipped.h"

namespace driftwise::formats {
namespace {

TEST(Gunzip, GivesBackWhatZlibPressed) {
  std::string text;
  for (int i = 0; i < 50000; ++i) text += std::to_string(std::int64_t{i} * i) + ";";
  const auto out = gunzip(tests::gzipped(text), "a.gz", text.size());
  ASSERT_TRUE(out) << out.error().message;
  EXPECT_EQ(*out, text);
}

TEST(Gunzip, ReadsAllMembersOfAFile) {
  EXPECT_EQ(
      *gunzip(tests::gzipped("a;b\n") + tests::gzipped("") + tests::gzipped("1;2\n"), "a.gz", 100),
      "a;b\n1;2\n");
}

TEST(Gunzip, RefusesHalfAFileAtEveryByte) {
  const std::string whole = tests::gzipped("time;x\n1;2\n3;4\n");
  for (std::size_t size = 2; size < whole.size(); ++size) {
    const auto out = gunzip(whole.substr(0, size), "a.gz", 1000);
    ASSERT_FALSE(out) << size;
    EXPECT_EQ(out.error().reason, "TRUNCATED_GZIP") << size;
    EXPECT_THAT(out.error().message, testing::StartsWith("a.gz: "));
  }
}

TEST(Gunzip, RefusesDamageAndWhatFollowsTheEnd) {
  const std::string whole = tests::gzipped(std::string(1000, 'x') + "y");
  std::string damaged = whole;
  damaged[damaged.size() - 6] ^= 1;  // the checksum
  EXPECT_EQ(gunzip(damaged, "a.gz", 5000).error().reason, "BAD_GZIP");
  EXPECT_EQ(gunzip(whole + "rest", "a.gz", 5000).error().reason, "BAD_GZIP");
}

TEST(Gunzip, StopsWhereASmallFileHoldsAHugeOne) {
  const std::string bomb = tests::gzipped(std::string(1 << 24, '0'));
  ASSERT_LT(bomb.size(), 20000U);
  EXPECT_EQ(gunzip(bomb, "bomb.gz", 1 << 20).error().reason, "TOO_LARGE");
}

TEST(ToUtf8, KnowsTheEncodingsOfMeasuringPrograms) {
  EXPECT_EQ(*to_utf8("\xEF\xBB\xBFx", TextEncoding::utf_8, "f"), "x");
  EXPECT_EQ(*to_utf8("20 \xB0"
                     "C",
                     TextEncoding::latin_1, "f"),
            "20 \xC2\xB0"
            "C");
  using namespace std::string_literals;
  EXPECT_EQ(*to_utf8("\xFF\xFEx\0\xB5\0\x3D\xD8\x00\xDE"s, TextEncoding::utf_8, "f"),
            "x\xC2\xB5\xF0\x9F\x98\x80");
  EXPECT_EQ(*to_utf8("\xFE\xFF\x20\xAC"s, TextEncoding::latin_1, "f"), "\xE2\x82\xAC");
  EXPECT_EQ(*to_utf8("x\0"s, TextEncoding::utf_16_le, "f"), "x");
}

TEST(ToUtf8, RefusesWhatIsNoText) {
  using namespace std::string_literals;
  EXPECT_EQ(to_utf8("a\0b"s, TextEncoding::utf_8, "f").error().reason, "NOT_TEXT");
  EXPECT_EQ(to_utf8("abc", TextEncoding::utf_16_le, "f").error().reason, "NOT_TEXT");
  EXPECT_EQ(to_utf8("\x00\xDC"s, TextEncoding::utf_16_le, "f").error().reason, "NOT_TEXT");
  EXPECT_EQ(to_utf8("\x3D\xD8"s, TextEncoding::utf_16_le, "f").error().reason, "NOT_TEXT");
}

}  // namespace
}  // namespace driftwise::formats
