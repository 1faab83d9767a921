#include "server/compensation/correction_parts.h"

#include <gtest/gtest.h>

#include "server/compensation/snapshot_builder.h"
#include "tests/unit/compensation/models.h"

namespace driftwise::compensation {
namespace {

constexpr CellTime kPartsTime{1'300'000'000'000'000'000};

SnapshotBuilder warm_builder(double t07_degc) {
  auto made = SnapshotBuilder::create(axis_model(), ModelId{1}, axis_cell());
  EXPECT_TRUE(made) << made.error().message;
  const ChannelValue value{"t07_degC", t07_degc};
  made->observe(std::span(&value, 1), kPartsTime);
  return std::move(*made);
}

TargetRequest at_x(double x_mm) {
  TargetRequest request;
  request.set(Variable::x, x_mm);
  return request;
}

TEST(CorrectionParts, CountTemperaturesFromTheMiddleOfTheirRangeInTheModelsOwnDatum) {
  auto builder = warm_builder(21.5);  // fitted between 20 and 22
  builder.keep_model_datum();
  const auto snapshot = builder.build(kPartsTime);
  const auto parts = correction_parts(snapshot, at_x(2), 0);
  ASSERT_TRUE(parts);
  // q1 = 1 + 2 x + 0.5 x^2 + 1e-3 t + 2e-4 x t
  EXPECT_NEAR(parts->temperatures_nm, 1e6 * (1e-3 * 0.5 + 2e-4 * 2 * 0.5), 1e-3);
  // The slope is 2: the motor does not follow x, so its own straight line is taken off.
  EXPECT_NEAR(parts->geometry_nm, 1e6 * 0.5 * 4, 1e-3);
  EXPECT_EQ(parts->force_nm, 0);
  const double straight_mm = 1 + 1e-3 * 21 + (2 + 2e-4 * 21) * 2;
  EXPECT_NEAR(parts->sum_nm(), 1e6 * (compute_target(snapshot, at_x(2)).q_mm[0] - straight_mm),
              1e-3);
}

TEST(CorrectionParts, CountTemperaturesSinceTheZeroOfAnotherDatum) {
  auto builder = warm_builder(21.5);
  ASSERT_TRUE(builder.anchor(std::vector<ChannelValue>{{"q1_mm", 0.01}, {"t07_degC", 21.5}}));
  const ChannelValue warmer{"t07_degC", 21.7};
  builder.observe(std::span(&warmer, 1), kPartsTime);
  const auto parts = correction_parts(builder.build(kPartsTime), at_x(0), 0);
  ASSERT_TRUE(parts);
  EXPECT_NEAR(parts->temperatures_nm, 1e6 * 1e-3 * 0.2, 1e-3);
  EXPECT_NEAR(parts->geometry_nm, 0, 1e-3) << "where the zero lies is no correction of this motor";
}

TEST(CorrectionParts, CountFromTheWantedCoordinateWhereTheMotorFollowsIt) {
  auto model = axis_model();
  model.outputs[0].coefficients << 0.01, 1.002, 0.0, 0.0, 0.0;
  auto made = SnapshotBuilder::create(model, ModelId{1}, axis_cell());
  ASSERT_TRUE(made);
  made->keep_model_datum();
  const auto parts = correction_parts(made->build(kPartsTime), at_x(2), 0);
  ASSERT_TRUE(parts);
  EXPECT_NEAR(parts->geometry_nm, 1e6 * (0.01 + 0.002 * 2), 1e-3) << "offset and scale with it";
}

TEST(CorrectionParts, AreNoneWhereTheRequestCannotBeAnswered) {
  auto builder = warm_builder(21);
  builder.keep_model_datum();
  const auto snapshot = builder.build(kPartsTime);
  EXPECT_FALSE(correction_parts(snapshot, TargetRequest{}, 0));
  EXPECT_FALSE(correction_parts(snapshot, at_x(1), 1)) << "no such output";
}

}  // namespace
}  // namespace driftwise::compensation
