#include <gtest/gtest.h>

#include <algorithm>

#include "server/formats/formula/formula.h"
#include "server/identification/identify.h"
#include "tests/unit/identification/robots.h"

namespace driftwise::identification {
namespace {

const IdentifiedParameter& delta_parameter(const Identification& found, const std::string& name) {
  return *std::ranges::find_if(found.parameters,
                               [&](const auto& one) { return one.parameter.name == name; });
}

KinematicsDescription crooked_delta() {
  auto delta = robots::nominal_delta();
  delta.branches[0].radius_mm += 0.05;
  delta.branches[0].length_mm -= 0.08;
  delta.branches[1].azimuth_deg += 0.04;
  delta.branches[1].length_mm += 0.06;
  delta.branches[2].radius_mm -= 0.03;
  delta.branches[2].offset_mm = 0.002;
  delta.branches[1].tilt_radial_deg = 0.03;
  delta.branches[2].tilt_tangential_deg = -0.02;
  delta.branches[0].scale_ppm = 40;
  return delta;
}

Identification identified_delta(const Dataset& data, const KinematicsDescription& nominal,
                                const std::string& formula = "") {
  IdentifyOptions options;
  options.mechanism = *kinematics::make_mechanism(nominal);
  if (!formula.empty()) options.terms = formats::Formula::parse(formula)->expand(data)->terms;
  auto found = identify(data, options);
  EXPECT_TRUE(found) << found.error().message;
  return std::move(*found);
}

TEST(IdentifyDelta, RecoversItsBranches) {
  const auto truth = crooked_delta();
  const auto found =
      identified_delta(robots::delta_campaign(truth, 6, {}, 41), robots::nominal_delta());
  EXPECT_LT(std::sqrt(found.rss.sum() / 648), 1e-9);
  EXPECT_NEAR(delta_parameter(found, "branch1.radius_mm").value, 45.05, 1e-5);
  EXPECT_NEAR(delta_parameter(found, "branch1.length_mm").value, 69.92, 1e-5);
  EXPECT_NEAR(delta_parameter(found, "branch2.azimuth_deg").value, 120.04, 1e-5);
  EXPECT_NEAR(delta_parameter(found, "branch2.tilt_radial_deg").value, 0.03, 1e-5);
  EXPECT_NEAR(delta_parameter(found, "branch3.tilt_tangential_deg").value, -0.02, 1e-5);
  EXPECT_NEAR(delta_parameter(found, "branch3.offset_mm").value, 0.002, 1e-7);
  EXPECT_NEAR(delta_parameter(found, "branch1.scale_ppm").value, 40, 1e-2);
}

TEST(IdentifyDelta, AFrameSaysNothingThatTheBranchesDoNot) {
  const auto found =
      identified_delta(robots::delta_campaign(crooked_delta(), 6, {}, 42), robots::nominal_delta());
  for (const char* name :
       {"frame.x_mm", "frame.y_mm", "frame.z_mm", "frame.rx_deg", "frame.ry_deg", "frame.rz_deg"}) {
    EXPECT_FALSE(delta_parameter(found, name).free) << name;
    EXPECT_NE(delta_parameter(found, name).note.find("cannot be told apart from branch"),
              std::string::npos)
        << name << ": " << delta_parameter(found, name).note;
  }
}

TEST(IdentifyDelta, AFrameIsIdentifiedWhereTheAxesAreHeldVertical) {
  auto truth = robots::nominal_delta();
  truth.branches[0].length_mm += 0.05;
  auto nominal = robots::nominal_delta();
  nominal.hold = {"*.tilt_*", "*.scale_ppm", "*.azimuth_deg"};
  const auto found = identified_delta(robots::delta_campaign(truth, 6, {}, 43), nominal);
  EXPECT_TRUE(delta_parameter(found, "frame.rz_deg").free);
  EXPECT_NEAR(delta_parameter(found, "frame.rz_deg").value, 0, 1e-6);
  EXPECT_NEAR(delta_parameter(found, "branch1.length_mm").value, 70.05, 1e-5);
}

TEST(IdentifyDelta, TakesHeatAndForceAlong) {
  const robots::DeltaNoise noise{.mm = 20e-6, .per_degc_mm = 300e-6, .per_n_mm = 50e-6};
  const auto found =
      identified_delta(robots::delta_campaign(crooked_delta(), 7, noise, 44),
                       robots::nominal_delta(), "q1 + q2 + q3 ~ poly(x, y, z, 3) + F + t05");
  ASSERT_EQ(found.terms.size(), 3U);  // the constant, F, t05: what the geometry does not read
  const double rms_nm = 1e6 * std::sqrt(found.rss.sum() / (3 * 343));
  EXPECT_LT(rms_nm, 21);
  EXPECT_GT(rms_nm, 18);
  for (Eigen::Index o = 0; o < 3; ++o) {
    // 343 rows of 20 nm: standard errors near 20 / (sqrt(343) * 1) nm per kelvin or newton.
    EXPECT_NEAR(found.coefficients(2, o), 300e-6 * static_cast<double>(o + 1),
                4 * found.standard_errors(2, o));
    EXPECT_NEAR(found.coefficients(1, o), 50e-6, 4 * found.standard_errors(1, o));
    EXPECT_LT(found.standard_errors(2, o), 3e-6);
  }
}

// Otherwise its coefficient is noise over nothing, and a fourth force is missed by millimetres.
TEST(IdentifyDelta, LeavesOutTheCubeOfThreeForces) {
  Dataset data = robots::delta_campaign(crooked_delta(), 7, {.mm = 20e-6}, 48);
  auto* force = const_cast<DatasetColumn*>(data.find("force"));
  ASSERT_NE(force, nullptr);
  const double levels[] = {0, 1.5, 2.3};
  for (std::size_t row = 0; row < data.rows; ++row)
    force->values[row] = levels[row % 3] + 1e-6 * static_cast<double>(row % 7);
  const auto found =
      identified_delta(data, robots::nominal_delta(), "q1 + q2 + q3 ~ F + F^2 + F^3");
  ASSERT_EQ(found.undetermined.size(), 1U);
  EXPECT_EQ(found.terms.size(), 3U);                          // the constant, F, F^2
  EXPECT_LT(found.coefficients.cwiseAbs().maxCoeff(), 1e-4);  // mm per N
}

TEST(IdentifyDelta, PredictsRowsItHasNotSeen) {
  const auto truth = crooked_delta();
  Dataset data = robots::delta_campaign(truth, 6, {}, 45);
  const auto found = identified_delta(data, robots::nominal_delta());
  const Dataset fresh = robots::delta_campaign(truth, 5, {}, 46);
  const auto predicted = predict(fresh, found);
  ASSERT_TRUE(predicted);
  for (std::size_t row = 0; row < fresh.rows; ++row)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR((*predicted)(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k)),
                  fresh.columns[3 + k].values[row], 1e-8);
}

TEST(IdentifyDelta, GivesEveryDatumItsOwnZero) {
  Dataset data = robots::delta_campaign(crooked_delta(), 6, {}, 47);
  data.datum.assign(data.rows, 1);
  for (std::size_t row = data.rows / 2; row < data.rows; ++row) {
    data.datum[row] = 2;
    for (std::size_t k = 3; k < 6; ++k) data.columns[k].values[row] += 400e-6;
  }
  const auto found = identified_delta(data, robots::nominal_delta());
  ASSERT_EQ(found.terms.size(), 2U);  // the constant, datum(2)
  EXPECT_LT(std::sqrt(found.rss.sum() / 648), 1e-9);
  for (Eigen::Index o = 0; o < 3; ++o) EXPECT_NEAR(found.coefficients(1, o), 400e-6, 1e-8);
}

}  // namespace
}  // namespace driftwise::identification
