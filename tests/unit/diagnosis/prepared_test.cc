#include "server/diagnosis/rows/prepared.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace driftwise::diagnosis
