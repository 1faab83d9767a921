// [[hold]] of a cell file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise::formats {
namespace {

using testing::HasSubstr;

const std::string kWithStabiliser = R"([cell]
name = "small"
database = "small.db"
[[device]]
id = "laser-x"
kind = "interferometer-adapter"
address = "127.0.0.1:1"
length = "x_mm"
[[device]]
id = "support"
kind = "watlow-ez-zone"
address = "127.0.0.1:2"
)";

Result<CellDescription> with(const std::string& hold) {
  return parse_cell_file(kWithStabiliser + hold, "cell.toml", drivers::all_devices());
}

std::string refusal(const std::string& hold) {
  const auto cell = with(hold);
  return cell ? std::string("it was taken") : cell.error().message;
}

TEST(CellFileHolds, AreReadWithTheirDefaults) {
  const auto cell = with(R"([[hold]]
name = "room"
channel = "support_degC"
above = 24
release_above = 23.5
action = "stop"
)");
  ASSERT_TRUE(cell) << cell.error().message;
  ASSERT_EQ(cell->holds.size(), 2u);  // and that of the stabiliser
  const auto& room = cell->holds.front();
  EXPECT_EQ(room.above, 24);
  EXPECT_EQ(room.release_above, 23.5);
  EXPECT_FALSE(room.below);
  EXPECT_EQ(room.for_s, 0);
  EXPECT_EQ(room.settle_s, 60);
  EXPECT_EQ(room.action, HoldAction::stop);
  EXPECT_TRUE(room.marks);
}

TEST(CellFileHolds, HaveOneForEachStabiliserUnlessToldOtherwise) {
  const auto cell = with("[checks]\nstabiliser_band_k = 0.02\n");
  ASSERT_TRUE(cell) << cell.error().message;
  ASSERT_EQ(cell->holds.size(), 1u);
  EXPECT_EQ(cell->holds[0].name, "stabiliser-support");
  EXPECT_EQ(cell->holds[0].channel, "support_degC");
  EXPECT_EQ(cell->holds[0].minus, "support_set_degC");
  EXPECT_EQ(cell->holds[0].above, 0.02);
  EXPECT_EQ(cell->holds[0].below, -0.02);
  const auto without = with("[checks]\nhold_on_stabilisers = false\n");
  ASSERT_TRUE(without) << without.error().message;
  EXPECT_TRUE(without->holds.empty());
}

TEST(CellFileHolds, ThatOfTheFileStandsInThePlaceOfAStabilisersOwn) {
  const auto cell = with(R"([[hold]]
name = "stabiliser-support"
channel = "support_degC"
minus = "support_set_degC"
above = 0.5
)");
  ASSERT_TRUE(cell) << cell.error().message;
  ASSERT_EQ(cell->holds.size(), 1u);
  EXPECT_EQ(cell->holds[0].above, 0.5);
}

TEST(CellFileHolds, ThatMakeNoSenseAreRefusedWithTheLine) {
  EXPECT_THAT(refusal("[[hold]]\nname = \"a\"\nchannel = \"t99_degC\"\nabove = 1\n"),
              testing::AllOf(HasSubstr("cell.toml"), HasSubstr("t99_degC"),
                             HasSubstr("expected a channel of this cell: air_degC, disk_free_GB")));
  EXPECT_THAT(refusal("[[hold]]\nname = \"a\"\nchannel = \"support_degC\"\n"),
              HasSubstr("neither above nor below"));
  EXPECT_THAT(refusal("[[hold]]\nname = \"a\"\nchannel = \"support_degC\"\nabove = 1\nbelow = 2\n"),
              HasSubstr("expected below to be the lower one"));
  EXPECT_THAT(refusal("[[hold]]\nname = \"a\"\nchannel = \"support_degC\"\nabove = 24\n"
                      "release_above = 25\n"),
              HasSubstr("would end while it is exceeded"));
  const std::string room = "[[hold]]\nname = \"a\"\nchannel = \"support_degC\"\nabove = 24\n";
  EXPECT_THAT(refusal(room + room), HasSubstr("which another [[hold]] has already"));
  EXPECT_THAT(refusal(room + "action = \"explode\"\n"), HasSubstr("finish-point"));
}

// A run waited for ever for the default names of an interferometer whose options name others.
TEST(CellFileHolds, KnowTheChannelsThatOptionsName) {
  const auto of = [](const std::string& channel) {
    return parse_cell_file(
        "[cell]\nname = \"small\"\ndatabase = \"small.db\"\n[[device]]\nid = "
        "\"laser-x\"\nkind = \"interferometer-adapter\"\naddress = "
        "\"127.0.0.1:1\"\nlength = \"x_mm\"\noptions = { air_channel = "
        "\"air_x_degC\", level_channel = \"level_x_pct\" }\n[[hold]]\nname = "
        "\"one\"\nchannel = \"" +
            channel + "\"\nabove = 30\n",
        "cell.toml", drivers::all_devices());
  };
  for (const char* given : {"air_x_degC", "level_x_pct", "x_std_nm"}) EXPECT_TRUE(of(given));
  for (const char* phantom : {"air_degC", "level_pct"}) {
    const auto cell = of(phantom);
    ASSERT_FALSE(cell) << phantom;
    EXPECT_EQ(cell.error().reason, "NO_SUCH_CHANNEL");
  }
}

}  // namespace
}  // namespace driftwise::formats
