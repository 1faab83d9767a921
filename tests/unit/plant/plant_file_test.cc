#include "drivers/simulated/plant/file/plant_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "drivers/simulated/plant/file/make_plant.h"
#include "drivers/simulated/plant/numbers/random.h"
#include "tests/support/plant_campaign.h"

namespace driftwise::simulated {
namespace {

std::string shipped_text() {
  std::ifstream in(testing_support::linear_axis_plant_file(DRIFTWISE_SOURCE_DIR));
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string replaced(const std::string& from, const std::string& to) {
  std::string text = shipped_text();
  const auto place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

std::string error_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse_plant_file(text, "plant.toml", overrides);
  } catch (const PlantFileError& error) {
    return error.what();
  }
  return "no error";
}

TEST(PlantFile, ReadsTheShippedOne) {
  const auto plant =
      std::get<LinearAxisParameters>(parse_plant_file(shipped_text(), "plant.toml", {}));
  EXPECT_EQ(plant.thermometers.size(), 10U);
  EXPECT_EQ(plant.thermometers[4].name, "t05");
  EXPECT_NEAR(plant.parts.front().capacity_j_k, 2.26 * 480, 1e-9);  // base_bottom, by hand
}

struct Bad {
  const char* name;
  const char* from;
  const char* to;
  const char* says;
};
class BadPlantFile : public testing::TestWithParam<Bad> {};

TEST_P(BadPlantFile, IsNamedByLineFieldFoundAndExpected) {
  const std::string error = error_of(replaced(GetParam().from, GetParam().to));
  EXPECT_THAT(error, testing::MatchesRegex("plant\\.toml:[0-9]+: .*"));
  EXPECT_THAT(error, testing::HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadPlantFile,
    testing::Values(
        Bad{"text_for_number", "cycle_s = 480.0", "cycle_s = \"long\"",
            "room.cycle_s: found 'long' (string), expected a number from 10 to 100000"},
        Bad{"negative_mass", "mass_kg = 0.972", "mass_kg = -1",
            "part.support.mass_kg: found -1, expected a number above 0"},
        Bad{"missing_key", "seebeck_v_k = 0.05", "",
            "stabiliser.seebeck_v_k: found nothing, expected a number above 0"},
        Bad{"unknown_key", "level_pct = 85.0", "level_pct = 85.0\nlevel = 3",
            "interferometer.level: found a key that means nothing here"},
        Bad{"unknown_part", "between = [\"bridge\", \"base_top\"]",
            "between = [\"bridge\", \"roof\"]", "link.bridge_base.between: found 'roof'"},
        Bad{"unknown_material", "material = \"zerodur\"", "material = \"cheese\"",
            "found 'cheese', expected one of the materials: acrylic, aluminium"},
        Bad{"open_loop", "length_mm = 80.0", "length_mm = 70.0", "a loop closes"},
        Bad{"shared_input", "input = 102", "input = 101", "which t01 has already"},
        Bad{"kind", "kind = \"linear-axis\"", "kind = \"delta\"",
            "expected linear-axis, micro-nano, min-angle, two-robots or delta-cube"},
        Bad{"not_toml", "[plant]", "[plant", "not TOML"},
        Bad{"schedule", "[[0.0833, 22.0]", "[[0.0833]", "expected a list of lists of 2 numbers"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(PlantOverride, ReplacesAValue) {
  const auto plant = std::get<LinearAxisParameters>(
      parse_plant_file(shipped_text(), "plant.toml",
                       std::vector<std::string>{"room.wander_w=0", "part.scale.material=glass"}));
  EXPECT_EQ(plant.room.wander_w, 0);
  EXPECT_NEAR(plant.parallelogram.scale_expansion_per_k, 8e-6, 1e-12);
}

TEST(PlantOverride, IsCheckedLikeTheFile) {
  EXPECT_EQ(error_of(shipped_text(), {"room.cycle_s=no"}),
            "override: room.cycle_s: found 'no' (string), expected a number from 10 to 100000");
  EXPECT_EQ(error_of(shipped_text(), {"room.cyclo_s=1"}),
            "override: room.cyclo_s: the plant file has no such key");
  EXPECT_EQ(error_of(shipped_text(), {"attic.x=1"}),
            "override: attic.x: the plant file has no table 'attic'");
  EXPECT_EQ(error_of(shipped_text(), {"nonsense"}),
            "override: found 'nonsense', expected section.key=value");
}

std::string micro_nano_text() {
  std::ifstream in(DRIFTWISE_SOURCE_DIR "/deploy/cells/micro-nano/plant.toml");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(MicroNanoPlantFile, ReadsTheShippedOne) {
  const auto plant =
      std::get<MicroNanoParameters>(parse_plant_file(micro_nano_text(), "plant.toml", {}));
  EXPECT_EQ(plant.thermometers.size(), 10U);
  EXPECT_EQ(plant.axes.size(), 3U);
  // Lengths that must close: the joints' radius; 150 + 30 - 40 mm of height; dead paths.
  double radius_mm = 0, height_mm = 0;
  for (const auto& length : plant.delta.outwards[1]) radius_mm += length.mm;
  for (const auto& length : plant.delta.upwards[1]) height_mm += length.mm;
  EXPECT_NEAR(radius_mm, plant.delta.column_radius_mm, 1e-9);
  EXPECT_NEAR(height_mm, 140, 1e-9);
  const auto to_head_mm = [&](std::size_t beam) {
    double sum_mm = 0;
    for (const auto& length : plant.beams[beam].datum) {
      if (length.parts.size() == 1) sum_mm += length.mm;  // the columns carry, they do not lead
    }
    for (const auto& length : plant.beams[beam].device) sum_mm += length.mm;
    return sum_mm;
  };
  const double half_mm = plant.cube.edge_mm / 2;
  EXPECT_NEAR(plant.interferometers[0].dead_path_mm,
              to_head_mm(0) + plant.cube.centre_mm.x - half_mm, 1e-9);
  EXPECT_NEAR(plant.interferometers[1].dead_path_mm, to_head_mm(1) - half_mm, 1e-9);
  EXPECT_NEAR(plant.interferometers[2].dead_path_mm, to_head_mm(2) + plant.optics.fold_height_mm,
              1e-9);
}

TEST(MicroNanoPlantFile, NamesWhatIsWrong) {
  const auto error = [](const std::string& override_text) {
    return error_of(micro_nano_text(), {override_text});
  };
  EXPECT_THAT(error("cube.centre_mm=[1, 2]"), testing::HasSubstr("expected a list of 3 numbers"));
  EXPECT_THAT(error("delta.arm_mm=40"), testing::HasSubstr("too short to reach"));
  EXPECT_THAT(error("delta.arm_material=cheese"), testing::HasSubstr("found 'cheese'"));
  EXPECT_THAT(error("loop.x_base.beam=w"), testing::HasSubstr("expected x, y or z"));
  EXPECT_THAT(error("carriage.column.axis=sideways"), testing::HasSubstr("outwards or upwards"));
  EXPECT_THAT(error("axis.motor_parts=[\"motor_1\"]"), testing::HasSubstr("three parts"));
  EXPECT_THAT(error("load.friction=2"), testing::HasSubstr("load.friction: found 2"));
  EXPECT_THAT(error("plant.machine=-1"), testing::HasSubstr("plant.machine"));
}

TEST(MicroNanoPlantFile, SurvivesDamage) {
  const std::string text = micro_nano_text();
  Random random(2, "damage");
  int refused = 0;
  for (int k = 0; k < 100; ++k) {
    std::string damaged = text;
    for (int hit = 0; hit < 3; ++hit) {
      const auto place =
          static_cast<std::size_t>(random.uniform() * static_cast<double>(text.size()));
      damaged[place] = static_cast<char>(random.uniform(1, 127));
    }
    if (error_of(damaged) != "no error") ++refused;
  }
  EXPECT_GT(refused, 10);
}

TEST(PlantFile, SaysWhichFileIsMissing) {
  EXPECT_THROW(
      {
        try {
          make_plant("/nowhere/plant.toml", {});
        } catch (const PlantFileError& error) {
          EXPECT_THAT(error.what(), testing::StartsWith("/nowhere/plant.toml: cannot be read"));
          throw;
        }
      },
      PlantFileError);
}

TEST(PlantFile, SurvivesDamage) {
  const std::string text = shipped_text();
  Random random(1, "damage");
  int refused = 0;
  for (int k = 0; k < 200; ++k) {
    std::string damaged = text;
    for (int hit = 0; hit < 3; ++hit) {
      const auto place =
          static_cast<std::size_t>(random.uniform() * static_cast<double>(text.size()));
      damaged[place] = static_cast<char>(random.uniform(1, 127));
    }
    if (error_of(damaged) != "no error") ++refused;  // anything but PlantFileError fails the test
  }
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace driftwise::simulated
