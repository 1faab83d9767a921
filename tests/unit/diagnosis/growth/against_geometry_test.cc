// Effects that mostly go with the place, and still are no geometry: a laser's wave whose phase only
// temperature turns, a lever whose tilt is mostly the guide's, the expansion by a part that hardly
// warms.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/diagnosis/diagnosed.h"

namespace driftwise::diagnosis {
namespace against_geometry_test {
namespace {

using ::testing::ElementsAre;

// A table with two slides of 60 mm, 6 x 5 positions, twelve rounds: x as a laser reads it, one part
// that swings by a quarter of a kelvin and one by a hundredth, the carriage's tilt.
struct Table {
  std::vector<double> time_s, q1_mm, q2_mm, x_mm, y_mm, rz_arcsec, warm_degC, steady_degC;

  explicit Table(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (std::size_t row = 0; row < 360; ++row) {
      const std::size_t round = row / 30, line = row % 30 / 6, along = row % 6;
      const double hours = static_cast<double>(row) * 20 / 3600;
      time_s.push_back(20.0 * static_cast<double>(row));
      q1_mm.push_back(12.0 * static_cast<double>(line % 2 == 0 ? along : 5 - along));
      q2_mm.push_back(15.0 * static_cast<double>(line));
      warm_degC.push_back(20 + 0.25 * std::sin(2 * std::numbers::pi * hours / 1.3) +
                          0.001 * normal(random));
      steady_degC.push_back(21 + 0.012 * std::sin(2 * std::numbers::pi * hours / 0.9 + 1) +
                            0.001 * normal(random));
      const double u = q1_mm.back() / 30 - 1;
      // The guide bends, and the carriage rocks a little otherwise in each round.
      rz_arcsec.push_back(3 * u * u - u + 0.7 * std::sin(1.9 * static_cast<double>(round)) +
                          0.05 * normal(random));
      x_mm.push_back(q1_mm.back() + 2e-4 * u * u + 280e-6 * (warm_degC.back() - 20) +
                     15e-6 * normal(random));
      y_mm.push_back(q2_mm.back() + 15e-6 * normal(random));
    }
  }

  Diagnosis diagnosed() const {
    Dataset data;
    data.rows = time_s.size();
    data.time_s = time_s;
    data.columns = {{{"q1", "mm"}, q1_mm},         {{"q2", "mm"}, q2_mm},
                    {{"x", "mm"}, x_mm},           {{"y", "mm"}, y_mm},
                    {{"rz", "arcsec"}, rz_arcsec}, {{"t01", "degC"}, warm_degC},
                    {{"t02", "degC"}, steady_degC}};
    return diagnosis::diagnosed(data, "q1 ~ x + x^2 + T");
  }
};

// Half a wavelength: each place is come to at one phase, but for the radian by which the warm part
// turns it.
TEST(ALasersWave, IsNamedWhereTemperatureTurnsItsPhase) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Table table(seed);
    for (double& x : table.x_mm) x += 40e-6 * std::sin(2 * std::numbers::pi * x / 316.4e-6);
    const auto found = table.diagnosed();
    ASSERT_THAT(names_found(found), ElementsAre("cyclic_error x")) << seed;
    EXPECT_NEAR(found.findings[0].parameters[0].value, 316.4, 0.2) << seed;
  }
}

// Three quarters of the tilt are a parabola of the place; the rocking tells the lever from it.
TEST(ALever, IsNamedThoughItsTiltIsMostlyTheGuides) {
  for (const std::uint64_t seed : {4, 5, 6}) {
    Table table(seed);
    constexpr double kLever_mm = 4, kRadPerArcsec = std::numbers::pi / 648000;
    for (std::size_t row = 0; row < table.x_mm.size(); ++row)
      table.x_mm[row] += kLever_mm * kRadPerArcsec * table.rz_arcsec[row];
    EXPECT_THAT(names_found(table.diagnosed()), ElementsAre("abbe_offset x")) << seed;
  }
}

// A bent guide without a lever: no tilt may take its place.
TEST(ALever, IsNotNamedForABentGuide) {
  for (const std::uint64_t seed : {7, 8, 9}) {
    Table table(seed);
    for (std::size_t row = 0; row < table.x_mm.size(); ++row) {
      const double u = table.q1_mm[row] / 30 - 1;
      table.x_mm[row] += 40e-6 * (u * u * u - 0.6 * u);
    }
    EXPECT_THAT(names_found(table.diagnosed()), ElementsAre("geometry_order x")) << seed;
  }
}

// A scale on the part that swings by a hundredth of a kelvin: position times temperature is then
// position nearly altogether, and the rest of it is the effect.
TEST(AnExpansion, IsOfThePartThatHardlyWarms) {
  for (const std::uint64_t seed : {10, 11, 12}) {
    Table table(seed);
    for (std::size_t row = 0; row < table.x_mm.size(); ++row)
      table.x_mm[row] += 60e-6 * table.x_mm[row] * (table.steady_degC[row] - 21);
    EXPECT_THAT(names_found(table.diagnosed()), ElementsAre("thermal_expansion t02")) << seed;
  }
}

// A screw of 300 mm at fourteen places that no lattice has, ten times each: ISO 230-2.
struct Screw {
  std::vector<double> time_s, q1_mm, x_mm, degc;

  explicit Screw(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> shift_mm(-4, 4);
    std::array<double, 14> places_mm{};
    for (std::size_t k = 0; k < places_mm.size(); ++k)
      places_mm[k] = 6 + 22.0 * static_cast<double>(k) + shift_mm(random);
    for (std::size_t row = 0; row < 20 * places_mm.size(); ++row) {
      const std::size_t pass = row / places_mm.size(), along = row % places_mm.size();
      time_s.push_back(60.0 * static_cast<double>(row));
      q1_mm.push_back(places_mm[pass % 2 == 0 ? along : places_mm.size() - 1 - along]);
      degc.push_back(21 + 0.5 * std::sin(2e-4 * time_s.back()) + 0.002 * normal(random));
      x_mm.push_back(q1_mm.back() + 100e-6 * normal(random));
    }
  }
  std::vector<std::string> names() const {
    Dataset data;
    data.rows = time_s.size();
    data.time_s = time_s;
    data.columns = {{{"q1", "mm"}, q1_mm}, {{"x", "mm"}, x_mm}, {{"t01", "degC"}, degc}};
    return names_found(diagnosed(data, "q1 ~ x + x^2 + t01"));
  }
};

// Waves a thousand times shorter than the places are apart take nearly any values there. Of these
// bumps the best of the waves leaves chi squared of 11 to 84 on nine further values of the places;
// where it leaves no more than chance does, the bump still has its name.
TEST(ABumpOfAGuide, IsHardlyEverAWaveShorterThanItsPlacesAreApart) {
  int waves = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Screw screw(seed);
    const double at_mm = 60 + 25.0 * static_cast<double>(seed);
    for (double& x : screw.x_mm) x += 350e-6 * std::exp(-std::pow((x - at_mm) / 18, 2) / 2);
    waves += std::ranges::any_of(
        screw.names(), [](const std::string& name) { return name.starts_with("cyclic_error"); });
  }
  EXPECT_LE(waves, 2);
}

TEST(AWaveOfAScale, IsNamedOnAsFewPlaces) {
  int named = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Screw screw(seed);
    for (std::size_t row = 0; row < screw.x_mm.size(); ++row)
      screw.x_mm[row] += 150e-6 * std::sin(2 * std::numbers::pi * screw.q1_mm[row] / 5);
    const auto names = screw.names();
    named += names.size() == 1 && names[0].starts_with("cyclic_error");
  }
  EXPECT_GE(named, 7);
}

}  // namespace
}  // namespace against_geometry_test
}  // namespace driftwise::diagnosis
