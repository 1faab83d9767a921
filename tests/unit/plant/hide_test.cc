// --hide: what is asked for becomes a plant, what is drawn repeats, what cannot be is refused.

#include "drivers/simulated/plant/file/hide.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "tests/unit/plant/plant_fixture.h"

namespace driftwise::simulated {
namespace {

using testing::HasSubstr;

std::string plant_file(const std::string& cell) {
  return std::string(DRIFTWISE_SOURCE_DIR) + "/deploy/cells/" + cell + "/plant.toml";
}

std::vector<std::string> overrides_of(const std::vector<HiddenCause>& causes) {
  std::vector<std::string> all;
  for (const auto& cause : causes) all.push_back(cause.override);
  return all;
}

std::string refusal(const std::string& wanted) {
  try {
    hide(wanted, read_plant_file(plant_file("linear-axis"), {}), 1);
  } catch (const PlantFileError& error) {
    return error.what();
  }
  return "";
}

TEST(Hide, MakesAPlantOfEveryCauseOnBothRobots) {
  for (const std::string cell : {"linear-axis", "micro-nano"}) {
    const auto plant = read_plant_file(plant_file(cell), {});
    for (const char* cause :
         {"backlash", "creep", "self_heating", "cyclic_error", "step_change", "thermal_lag",
          "instrument_drift", "periodic_disturbance", "outliers", "noise_change", "sensor_fault"}) {
      const auto causes = hide(cause, plant, 1);
      ASSERT_EQ(causes.size(), 1u);
      EXPECT_NO_THROW(read_plant_file(plant_file(cell), overrides_of(causes)))
          << cell << " " << causes[0].override;
    }
  }
}

// A sliding contact of friction f on a structure of stiffness k bends it by f/k to either side.
TEST(Hide, MakesALoopAsWideAsWasAskedFor) {
  const auto causes = hide("backlash:q1=80nm,thermal_lag:t07=1800s",
                           read_plant_file(plant_file("linear-axis"), {}), 1);
  ASSERT_EQ(causes.size(), 2u);
  const auto made = read_plant_file(plant_file("linear-axis"), overrides_of(causes));
  const auto& hidden = std::get<LinearAxisParameters>(made).hidden;
  ASSERT_EQ(hidden.size(), 2u);
  const auto& friction = std::get<HiddenFriction>(hidden[0].effect);
  EXPECT_NEAR(2 * friction.friction_n / friction.stiffness_n_um * 1000, 80, 1e-3);
  const auto& slab = std::get<HiddenSlab>(hidden[1].effect);
  EXPECT_NEAR(
      slab.density_kg_m3 * slab.heat_capacity_j_kgk * slab.thickness_mm * 1e-3 / slab.film_w_m2k,
      1800, 60)
      << "the lumped time constant; the plant's own steel may differ by some percent";
}

TEST(Hide, DrawsTheSameForTheSameSeedAndAllThatItMayOverSeeds) {
  const auto plant = read_plant_file(plant_file("linear-axis"), {});
  std::map<std::string, int> seen;
  int pairs = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const auto causes = hide("random", plant, seed);
    EXPECT_EQ(overrides_of(causes), overrides_of(hide("random", plant, seed)));
    pairs += causes.size() == 2 ? 1 : 0;
    std::set<std::string> symbols;
    for (const auto& cause : causes) {
      ++seen[cause.cause];
      EXPECT_TRUE(symbols.insert(cause.symbol).second);
    }
    EXPECT_NO_THROW(read_plant_file(plant_file("linear-axis"), overrides_of(causes)));
  }
  EXPECT_EQ(seen.size(), 8u) << "what a plan of some hours can show";
  EXPECT_NEAR(pairs, 100, 35);
}

TEST(Hide, WritesTheAnswerDown) {
  const auto causes =
      hide("step_change:q1=120nm", read_plant_file(plant_file("linear-axis"), {}), 7);
  EXPECT_EQ(hidden_answer_json(causes, 7),
            "{\"schema\":\"driftwise.hidden.v1\",\"seed\":7,\"hidden\":[{\"cause\":\"step_change\","
            "\"symbol\":\"q1\",\"size\":120,\"unit\":\"nm\"}]}\n");
}

TEST(Hide, SaysWhatThereIsWhereSomethingElseWasAskedFor) {
  EXPECT_THAT(refusal("ghosts"), HasSubstr("found 'ghosts', expected random or a cause: backlash"));
  EXPECT_THAT(refusal("backlash:q2=80nm"), HasSubstr("found 'q2', expected one of q1"));
  EXPECT_THAT(refusal("backlash:q1=80um"), HasSubstr("expected a size in nm"));
  EXPECT_THAT(refusal("backlash:q1=8e9nm"), HasSubstr("from 2 to 4000"));
  EXPECT_THAT(refusal(""), HasSubstr("expected random or a cause"));
  EXPECT_THAT(refusal("backlash,,creep"), HasSubstr("expected random or a cause"));
}

}  // namespace
}  // namespace driftwise::simulated
