#include "server/rpc/shared/convert_values.h"

#include <gtest/gtest.h>

#include "server/rpc/configuration/convert_provenance.h"
#include "server/rpc/diagnosis/convert_diagnosis.h"

namespace driftwise::rpc {
namespace {

TEST(Timestamps, CountNanosForwardAlsoBefore1970) {
  const auto t = timestamp_from(CellTime{-1});
  EXPECT_EQ(t.seconds(), -1);
  EXPECT_EQ(t.nanos(), 999'999'999);
  EXPECT_EQ(timestamp_from(CellTime{1'500'000'000}).nanos(), 500'000'000);
}

TEST(Durations, OfAbsurdNumbersAreZero) {
  EXPECT_EQ(duration_from_s(std::nan("")).seconds(), 0);
  EXPECT_EQ(duration_from_s(1e300).seconds(), 0);
  EXPECT_EQ(duration_from_s(2.5).nanos(), 500'000'000);
}

struct Case {
  const char* name;
  std::string in, out;
};
class Utf8 : public testing::TestWithParam<Case> {};
TEST_P(Utf8, KeepsWhatIsValidAndMarksTheRest) {
  EXPECT_EQ(utf8_from(GetParam().in), GetParam().out);
}
// Malformed forms after the Unicode standard, table 3-7 (well-formed UTF-8 byte sequences).
INSTANTIATE_TEST_SUITE_P(
    Table, Utf8,
    testing::Values(Case{"ascii", "ok", "ok"}, Case{"two", "\xc3\xbc", "\xc3\xbc"},
                    Case{"three", "\xe2\x82\xac", "\xe2\x82\xac"},
                    Case{"four", "\xf0\x9f\xa6\xa4", "\xf0\x9f\xa6\xa4"},
                    Case{"lone_tail", "\x80", "?"}, Case{"cut", "a\xe2\x82", "a??"},
                    Case{"overlong2", "\xc0\xaf", "??"}, Case{"overlong3", "\xe0\x80\xaf", "???"},
                    Case{"surrogate", "\xed\xa0\x80", "???"},
                    Case{"beyond", "\xf4\x90\x80\x80", "????"}, Case{"empty", "", ""}),
    [](const auto& row) { return std::string(row.param.name); });

// The record counts rows from 0; a person, and what ExcludeRows takes, from 1.
TEST(Previews, CountRowsFromOneAsAnAcceptedExtensionDoes) {
  ExtensionRecord accepted;
  accepted.excluded = {{RunId{3}, {41, 42, 87}}};
  application::ExtensionPreview preview;
  preview.excluded = accepted.excluded;
  const auto before = preview_from(preview);
  const auto after = extension_from(accepted);
  ASSERT_EQ(before.excluded_size(), 2);
  EXPECT_EQ(before.excluded(0).first_row(), 42);
  EXPECT_EQ(before.excluded(0).last_row(), 43);
  EXPECT_EQ(before.excluded(1).first_row(), 88);
  ASSERT_EQ(after.excluded_size(), 2);
  for (int i = 0; i < 2; ++i)
    EXPECT_EQ(before.excluded(i).DebugString(), after.excluded(i).DebugString());
}

}  // namespace
}  // namespace driftwise::rpc
