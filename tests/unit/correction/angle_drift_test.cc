#include "server/correction/angle_drift.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace driftwise::correction {
namespace {

using testing::HasSubstr;

// A weekend of two datums: every fifth row a return to zero, the mount of a 45 degree mirror turns
// by 0.8 arcsec/K, and noise of 0.02 arcsec.
Dataset weekend(double arcsec_per_k, double noise_arcsec, unsigned seed, double span_k = 2.0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_arcsec);
  Dataset data;
  data.rows = 200;
  DatasetColumn ry{{"ry", "arcsec"}, {}}, t05{{"t05", "degC"}, {}}, q{{"q1", "mm"}, {}};
  for (std::size_t row = 0; row < data.rows; ++row) {
    const bool zero = row % 5 == 0;
    const double k = span_k * std::sin(0.03 * static_cast<double>(row));
    const std::int64_t datum = row < 100 ? 7 : 8;
    data.zero.push_back(zero);
    data.datum.push_back(datum);
    data.time_s.push_back(60.0 * static_cast<double>(row));
    q.values.push_back(zero ? 0.0 : 1.0);
    t05.values.push_back(21 + k);
    const double from_k = datum == 7 ? 0.0 : span_k * std::sin(3.0);
    ry.values.push_back((zero ? 0.0 : 12.5) + arcsec_per_k * (k - from_k) + noise(random));
  }
  data.columns = {q, ry, t05};
  return data;
}

TEST(AngleDrift, IsFoundFromReturnsToZeroWithItsUncertainty) {
  // 40 returns; the estimate is normal about the truth: 200 seeds say how u covers.
  int within = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const auto drift = drift_from_returns(weekend(0.8, 0.02, seed), "ry", "t05");
    ASSERT_TRUE(drift) << drift.error().message;
    EXPECT_EQ(drift->returns, 40u);
    EXPECT_EQ(drift->datums, 2u);
    if (std::abs(drift->arcsec_per_k - 0.8) <= 2 * drift->u_arcsec_per_k) ++within;
  }
  // 95 % expected at 37 degrees of freedom; binomial, 200 draws: 179 .. 199 in 99.9 %.
  EXPECT_GE(within, 179);
  EXPECT_LE(within, 199);
}

TEST(AngleDrift, IsTakenOffTheRotationAloneFromEachDatumsFirstRow) {
  auto data = weekend(0.8, 0, 1);
  const auto drift = drift_from_returns(data, "ry", "t05");
  ASSERT_TRUE(drift);
  EXPECT_NEAR(drift->arcsec_per_k, 0.8, 1e-12);
  DataAmendment amendment;
  amendment.angles = {shift_from(*drift, "ry", "t05", "40 returns to zero")};
  const std::vector<RowOrigin> origins(data.rows, RowOrigin{{3}, 0});
  ASSERT_TRUE(amend(amendment, origins, {}, data));
  for (std::size_t row = 0; row < data.rows; ++row)
    EXPECT_NEAR(data.find("ry")->values[row], data.zero[row] ? 0.0 : 12.5, 1e-9) << row;
  EXPECT_EQ(data.find("q1")->values[1], 1.0);
}

TEST(AngleDrift, OfOtherRunsChangesNothing) {
  auto data = weekend(0.8, 0, 1);
  const auto before = data.find("ry")->values;
  DataAmendment amendment;
  amendment.angles = {shift_from({0.8, 0.1}, "ry", "t05", "stated", {{4}})};
  ASSERT_TRUE(amend(amendment, std::vector<RowOrigin>(data.rows, RowOrigin{{3}, 0}), {}, data));
  EXPECT_EQ(data.find("ry")->values, before);
}

TEST(AngleDrift, IsRefusedWhereItCannotBeSeen) {
  auto data = weekend(0.8, 0.02, 1);
  EXPECT_THAT(drift_from_returns(data, "x", "t05").error().message,
              HasSubstr("found 'x', expected a rotation of the data: ry"));
  EXPECT_THAT(drift_from_returns(data, "ry", "t99").error().message,
              HasSubstr("found 't99', expected one of the data: t05"));
  EXPECT_EQ(drift_from_returns(weekend(0.8, 0.02, 1, 0.005), "ry", "t05").error().reason,
            "BAD_RANGE");
  for (std::size_t row = 15; row < data.rows; ++row) data.zero[row] = 0;
  EXPECT_THAT(drift_from_returns(data, "ry", "t05").error().message,
              HasSubstr("found 3 returns to zero in 1 datums"));
  for (std::size_t row = 0; row < 5; ++row) data.zero[row] = 0;
  EXPECT_EQ(drift_from_returns(data, "ry", "t05").error().reason, "NO_POSE_ZERO");
  data.zero.clear();
  EXPECT_EQ(drift_from_returns(data, "ry", "t05").error().reason, "NO_POSE_ZERO");
}

}  // namespace
}  // namespace driftwise::correction
