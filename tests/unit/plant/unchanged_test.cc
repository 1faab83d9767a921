// Plants that hide nothing are bit for bit what they were before anything could be hidden in them.
// The digests were made by the code of commit 7cdf004, before [hidden] existed.

#include <gtest/gtest.h>

#include <bit>

#include "tests/support/micro_nano_campaign.h"
#include "tests/unit/plant/plant_fixture.h"

namespace driftwise::simulated {
namespace {

// FNV-1a over the bits of numbers.
class BitDigest {
 public:
  void add(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int byte = 0; byte < 8; ++byte) {
      value_ = (value_ ^ ((bits >> (8 * byte)) & 0xFF)) * 0x100000001B3ULL;
    }
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ULL;
};

TEST(PlantThatHidesNothing, IsTheLinearAxisItWas) {
  const auto plant = warm_plant(3);
  const auto campaign = testing_support::run_plant_campaign(*plant, kEpoch, {.passes = 3});
  BitDigest digest;
  for (const auto& row : campaign.rows) {
    for (const double value : {row.q1_mm, row.x_mm, row.x_std_nm, row.end_effector_nm,
                               row.air_error_nm, row.t_degc[3], row.t_degc[6]}) {
      digest.add(value);
    }
  }
  EXPECT_EQ(digest.value(), 14199969231107252930ULL);
}

TEST(PlantThatHidesNothing, IsTheMicroNanoItWas) {
  testing_support::MicroNanoOptions options;
  options.seed = 4;
  options.coarse = true;
  testing_support::MicroNanoSession session(DRIFTWISE_SOURCE_DIR, options);
  BitDigest digest;
  for (const double newton : {0.0, 1.536}) {
    session.load(newton);
    for (int k = 0; k < 12; ++k) {
      const auto row = session.visit({0.2 * k, 1.1, 2.0 - 0.1 * k});
      for (std::size_t i = 0; i < 3; ++i) {
        for (const double value :
             {row.q_mm[i], row.path_mm[i], row.r_arcsec[i], row.true_mm[i], row.t_degc[i + 3]}) {
          digest.add(value);
        }
      }
    }
  }
  EXPECT_EQ(digest.value(), 7422701490848269240ULL);
}

}  // namespace
}  // namespace driftwise::simulated
