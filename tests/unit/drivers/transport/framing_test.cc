#include "drivers/transport/framing.h"

#include <gtest/gtest.h>

#include "drivers/transport/escape.h"

namespace driftwise::transport {
namespace {

using namespace std::string_view_literals;

struct Case {
  const char* name;
  Framing framing;
  std::string_view bytes;
  std::size_t length;
};

class EndOfReply : public testing::TestWithParam<Case> {};
TEST_P(EndOfReply, IsFound) { EXPECT_EQ(GetParam().framing(GetParam().bytes), GetParam().length); }

INSTANTIATE_TEST_SUITE_P(
    Table, EndOfReply,
    testing::Values(
        Case{"nothing", line_reply, "", kIncomplete}, Case{"half", line_reply, "1.5", kIncomplete},
        Case{"lf", line_reply, "1.5\n", 4}, Case{"cr", line_reply, "1.5\r", 4},
        Case{"crlf_leaves_its_lf_for_the_next", line_reply, "1.5\r\n", 4},
        Case{"empty_lines_do_not_count", line_reply, "\n\r\n\r1.5\n", 8},
        Case{"only_ends", line_reply, "\r\n\r\n", kIncomplete},
        Case{"first_of_two", line_reply, "a\nb\n", 2}, Case{"zero_byte", line_reply, "a\0b\n"sv, 4},
        Case{"gcs_single", gcs_reply, "0\n", 2}, Case{"gcs_open", gcs_reply, "X=1 \n", kIncomplete},
        Case{"gcs_two_lines", gcs_reply, "X=1 \nY=2\n", 9},
        Case{"gcs_leading_end", gcs_reply, "\n0\n", 3},
        Case{"gcs_first_of_two_replies", gcs_reply, "X=1 \nY=2\n0\n", 9},
        Case{"gcs_blank_line", gcs_reply, " \n", kIncomplete}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(LineEnds, AreTakenOffBothSides) {
  EXPECT_EQ(without_line_ends("\r\n1 \r\n"), "1 ");
  EXPECT_EQ(without_line_ends("\r\n"), "");
}

TEST(Escaped, ShowsEveryByteAndCutsLongOnes) {
  EXPECT_EQ(escaped("a\r\n\x18\xb5\"\\"), "a\\r\\n\\x18\\xb5\\\"\\\\");
  EXPECT_EQ(escaped("abcdef", 4), "abcd...(+2 bytes)");
}

}  // namespace
}  // namespace driftwise::transport
