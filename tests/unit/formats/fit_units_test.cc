// The same readings in other units are the same fit.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "server/formats/formula/formula.h"
#include "server/formats/model/coefficient_unit.h"

namespace driftwise::formats {
namespace {

struct Unit {
  const char* name;
  double per_first;  // of the first unit
};

// A coordinate of 8 units that goes and comes back, with a play of 2e-3 of them, a wave of 0.02
// along the pose, and what is left of each move after 300 s.
Dataset moved(const Unit& of_motor, const Unit& of_pose, const char* pose) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> place(0, 8);
  Dataset data;
  std::vector<double> q, x;
  double side = 1, before = 0, creep = 0;
  for (std::size_t row = 0; row < 300; ++row) {
    const double at = place(random), move = row == 0 ? 0 : at - before;
    side = row == 0 ? 0 : move > 0 ? 1 : -1;
    creep = creep * std::exp(-20.0 / 300) + move;
    before = at;
    const double wave = 0.0002 * std::sin(2 * std::numbers::pi * at / 0.02);
    data.time_s.push_back(20.0 * static_cast<double>(row));
    x.push_back(of_pose.per_first * at);
    q.push_back(of_motor.per_first *
                (at + wave + 1e-3 * side + 1e-4 * creep + 2e-5 * normal(random)));
  }
  data.rows = data.time_s.size();
  data.columns = {{{"q1", of_motor.name}, q}, {{pose, of_pose.name}, x}};
  return data;
}

// In the first unit.
double u90(const Unit& motor, const Unit& of_pose, const char* pose, const std::string& formula) {
  const Dataset data = moved(motor, of_pose, pose);
  calibration::FitOptions options;
  options.select = calibration::Select::all;
  const auto model = fit_formula(data, formula, options);
  EXPECT_TRUE(model.has_value()) << formula << ": " << (model ? "" : model.error().message);
  return model ? model->outputs.front().accuracy.u90_calibration / motor.per_first : 0;
}

void expect_the_same_fit(const Unit& first, const std::vector<Unit>& others, const char* pose,
                         const std::string& formula) {
  const double wanted = u90(first, first, pose, formula);
  EXPECT_NEAR(wanted, 1.645 * 2e-5, 6e-6);  // of the noise
  for (const Unit& one : others)
    for (const Unit& other : others)
      EXPECT_NEAR(u90(one, other, pose, formula), wanted, 1e-3 * wanted)
          << one.name << " over " << other.name;
}

TEST(TheSameReadingsInOtherUnits, AreTheSameFitOfPlayCreepAndWaves) {
  expect_the_same_fit(
      {"mm", 1}, {{"m", 1e-3}, {"um", 1e3}, {"nm", 1e6}}, "x",
      "q1 ~ x + play(q1, 2000 nm) + creep(q1, 300 s) + sin(x, 20 um) + cos(x, 20000 nm)");
}

TEST(TheSameReadingsInOtherUnits, AreTheSameFitOfAnglesToo) {
  expect_the_same_fit(
      {"deg", 1}, {{"rad", std::numbers::pi / 180}, {"arcsec", 3600}}, "rz",
      "q1 ~ rz + play(q1, 7.2 arcsec) + creep(q1, 300 s) + sin(rz, 72 arcsec) + cos(rz, 0.02 deg)");
}

// mm/(mm mm mm) is a reader's puzzle.
TEST(TheUnitOfACoefficient, HasEachUnitOnceWithItsPower) {
  calibration::Model model;
  for (const char* pose : {"x", "y", "z"}) model.domain.push_back({{pose, "mm"}, 0, 1});
  model.domain.push_back({{"t07", "degC"}, 20, 21});
  model.domain.push_back({{"force", "N"}, 0, 1});
  model.domain.push_back({{"q1", "mm"}, 0, 1});
  calibration::OutputModel output;
  output.channel = {"q1", "mm"};
  const auto unit = [&](const std::string& term) {
    return coefficient_unit(output, *parse_term(term), model);
  };
  EXPECT_EQ(unit("x"), "mm/mm");
  EXPECT_EQ(unit("x:y^2:z"), "mm/mm^4");
  EXPECT_EQ(unit("x:y:t07"), "mm/(mm^2 degC)");
  EXPECT_EQ(unit("x:lag(t07, 300 s)"), "mm/(mm degC)");
  EXPECT_EQ(unit("contact(force)"), "mm/N^(2/3)");
  EXPECT_EQ(unit("play(q1, 200 nm)"), "mm/mm");
}

}  // namespace
}  // namespace driftwise::formats
