#include "server/formats/text/kept_stop.h"

#include <gtest/gtest.h>

namespace driftwise::formats {
namespace {

TEST(KeptStop, IsReadAsItWasWritten) {
  const auto stop = read_kept_stop(write_kept_stop({"Jürgen \"J\"", "2026-11-28T19:43:00Z"}));
  EXPECT_EQ(stop.who, "Jürgen \"J\"");
  EXPECT_EQ(stop.asked, "2026-11-28T19:43:00Z");
}

// A stop is never lost because its text is not understood.
TEST(KeptStop, IsAStopWhateverItsText) {
  for (const std::string& text :
       {std::string(), std::string("stop!"), std::string("[1]"), std::string("{\"who\": 3}"),
        std::string("{\"who\": \"\"}"), "{\"who\": \"" + std::string(5000, 'a') + "\"}",
        std::string("\xff\xfe\0", 3)}) {
    const auto stop = read_kept_stop(text);
    EXPECT_EQ(stop.who, "somebody") << text;
    EXPECT_EQ(stop.asked, "an unknown instant") << text;
  }
}

TEST(KeptStop, NamesAPersonInOneLineThatATerminalMayShow) {
  EXPECT_EQ(read_kept_stop(write_kept_stop({"eve\n\x1b[2J", ""})).who, "eve ?[2J");
}

}  // namespace
}  // namespace driftwise::formats
