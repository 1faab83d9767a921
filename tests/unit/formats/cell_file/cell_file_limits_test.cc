// [plausibility] and [[limit]] of a cell file.

#include <gtest/gtest.h>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/cell_file/cell_file_closure.h"

namespace driftwise::formats {
namespace {

const std::string kFront = R"([cell]
name = "small"
database = "small.db"
[[device]]
id = "laser-x"
kind = "interferometer-adapter"
address = "127.0.0.1:1"
length = "x_mm"
)";

TEST(CellFileLimits, AreRead) {
  const auto cell = parse_cell_file(kFront + R"([plausibility]
geometry_um = 5
geometry_pct = 0.1
closure_nm = 150
closure_nm_per_min = 10
closure_arcsec = 1
together_k = 0.02
[[limit]]
channel = "x_mm"
min = -3
max = 3.5
max_step = 0.001
max_per_s = 6
frozen_answers = 4
)",
                                    "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  const auto& rules = cell->plausibility;
  EXPECT_EQ(rules.geometry_um, 5);
  EXPECT_EQ(rules.geometry_pct, 0.1);
  EXPECT_EQ(rules.closure_nm, 150);
  EXPECT_EQ(rules.closure_nm_per_min, 10);
  EXPECT_EQ(rules.closure_arcsec, 1);
  EXPECT_EQ(rules.together_k, 0.02);
  ASSERT_EQ(rules.limits.size(), 1U);
  EXPECT_EQ(rules.limits[0].channel, "x_mm");
  EXPECT_EQ(rules.limits[0].max, 3.5);
  EXPECT_EQ(rules.limits[0].frozen_answers, 4);
}

TEST(CellFileLimits, MayBeOfWhatAnInterferometerTellsBeside) {
  for (const char* channel : {"air_degC", "level_pct", "x_std_nm"})
    for (const std::string table : {"limit", "channel_alarm"}) {
      const auto cell =
          parse_cell_file(kFront + "[[" + table + "]]\nchannel = \"" + channel + "\"\n" +
                              (table == "limit" ? "max" : "above") + " = 30\n",
                          "cell.toml", drivers::all_devices());
      EXPECT_TRUE(cell) << cell.error().message;
    }
}

TEST(CellFileLimits, OfReturnsToZeroAreRead) {
  const auto cell = parse_cell_file(kFront + R"([closure]
unexplained = "repeat"
repeats = 3
[[closure_limit]]
channel = "x_mm"
limit_nm = 200
)",
                                    "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  const auto rules = closure_rules_of(*cell);
  EXPECT_EQ(rules.unexplained, UnexplainedClosure::repeat);
  EXPECT_EQ(rules.repeats, 3);
  ASSERT_EQ(rules.limits.size(), 1U);
  EXPECT_EQ(rules.limits[0].channel, "x_mm");
  EXPECT_EQ(rules.limits[0].limit, 200);
}

TEST(CellFileLimits, HaveDefaults) {
  const auto cell = parse_cell_file(kFront + "[[limit]]\nchannel = \"x_mm\"\nmax = 2\n",
                                    "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->plausibility.closure_nm, 300);
  EXPECT_FALSE(cell->plausibility.closure_nm_per_min);
  EXPECT_FALSE(cell->plausibility.limits[0].min);
  EXPECT_FALSE(cell->plausibility.limits[0].frozen_answers);
}

TEST(CellFileLimits, AreRefusedWithTheirPlace) {
  const auto refused = [](const std::string& text) {
    const auto cell = parse_cell_file(kFront + text, "cell.toml", drivers::all_devices());
    return cell ? std::string() : cell.error().reason + ": " + cell.error().message;
  };
  EXPECT_NE(refused("[plausibility]\nclosure_nm = 0\n").find("OUT_OF_RANGE"), std::string::npos);
  EXPECT_NE(refused("[plausibility]\nclosure_mm = 1\n").find("UNKNOWN_KEY"), std::string::npos);
  EXPECT_NE(refused("[closure]\nunexplained = \"ignore\"\n").find("unexplained"),
            std::string::npos);
  EXPECT_NE(refused("[[closure_limit]]\nchannel = \"x_mm\"\nlimit_arcsec = 1\n").find("KEY"),
            std::string::npos);
  EXPECT_NE(refused("[[closure_limit]]\nchannel = \"t07_degC\"\nlimit_nm = 1\n").find("x_mm"),
            std::string::npos);
  EXPECT_NE(refused("[[limit]]\nmax = 1\n").find("MISSING_KEY"), std::string::npos);
  EXPECT_NE(
      refused("[[limit]]\nchanel = \"x_mm\"\n").find("channel: found 'chanel', expected this key"),
      std::string::npos);
  EXPECT_NE(refused("[[limit]]\nchannel = \"xx_mm\"\nmax = 2\n").find("NO_SUCH_CHANNEL"),
            std::string::npos)
      << "a limit of a channel that nothing reads guards nothing";
  EXPECT_NE(refused("[[limit]]\nchannel = \"x_mm\"\nmin = 2\nmax = 1\n").find("BAD_LIMITS"),
            std::string::npos);
  EXPECT_NE(refused("[[limit]]\nchannel = \"x_mm\"\n[[limit]]\nchannel = \"x_mm\"\n")
                .find("DUPLICATE_CHANNEL"),
            std::string::npos);
}

}  // namespace
}  // namespace driftwise::formats
