#include "server/diagnosis/rows/prepared.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace driftwise::diagnosis {
namespace {

const effects::Term kPlay{{effects::Call{"play", {"q1"}, {{20, "nm"}}}}};

// Forth and back over nine places, each visited twice before it moves on.
Dataset passes(double off_mm) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> off(-off_mm, off_mm);
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}};
  for (int pass = 0; pass < 6; ++pass)
    for (int k = 0; k < 18; ++k) {
      const double mm = (pass % 2 == 0 ? k / 2 : 8 - k / 2) + off(random);
      data.time_s.push_back(15.0 * static_cast<double>(data.rows++));
      for (auto& column : data.columns) column.values.push_back(mm);
    }
  return data;
}

Eigen::VectorXd play_of(const Dataset& data) {
  auto prepared = Prepared::of(data);
  prepared.set_path("q1", data.columns.front().values);
  return *prepared.columns({kPlay});
}

TEST(Prepared, PlayIsOfMovesBetweenPlacesAndNotOfWhereAnAxisStandsInOne) {
  constexpr double kOff_mm = 3e-5;
  const Eigen::VectorXd exact = play_of(passes(0)), held = play_of(passes(kOff_mm));
  EXPECT_LT((exact - held).norm(), 1e-6 * exact.norm());
}

// 0.5 K in a cycle of 20 min, read every 20 s without noise, one row missing after the tenth.
TEST(Prepared, ARateOverOneStepIsTheDerivativeAtTheRow) {
  constexpr double kCycle_s = 1200, kStep_s = 20;
  Dataset data;
  data.columns = {{{"t01", "degC"}, {}}};
  std::vector<double> per_h;
  for (int i = 0; i < 120; ++i) {
    const double t_s = kStep_s * (i < 10 ? i : i + 1), turn = 2 * std::numbers::pi / kCycle_s;
    data.time_s.push_back(t_s);
    data.columns[0].values.push_back(20 + 0.5 * std::sin(turn * t_s));
    per_h.push_back(3600 * 0.5 * turn * std::cos(turn * t_s));
    ++data.rows;
  }
  const Eigen::VectorXd rate = *Prepared::of(data).columns(
      {effects::Term{{effects::Call{"rate", {"t01"}, {{kStep_s, "s"}}}}}});
  // The line through neighbours leaves turn^2 step^2 / 6 = 0.2 % of 9.4; smoothing, one per cent.
  for (int i = 1; i < 119; ++i) EXPECT_NEAR(rate[i], per_h[static_cast<std::size_t>(i)], 0.15) << i;
  EXPECT_NEAR(per_h.front(), 9.4, 0.1);
}

}  // namespace
}  // namespace driftwise::diagnosis
