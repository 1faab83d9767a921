// Case B on the plant: do the study's models find what the physics does? Plain least squares of all
// terms on the corrected pose, no selection.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/simulated/plant/numbers/units.h"
#include "tests/support/micro_nano_campaign.h"
#include "tests/unit/plant/least_squares.h"

namespace driftwise::testing_support {
namespace {

using simulated::kRadPerArcsec;

struct Model {
  const char* name;
  bool force, temperatures, products, truth;
};
// The oracle is given what the plant's end-effector truly does, and fits the same terms.
constexpr std::array<Model, 6> kModels{{{"G", false, false, false, false},
                                        {"G+F", true, false, false, false},
                                        {"G+T", false, true, false, false},
                                        {"G+T+F", true, true, false, false},
                                        {"+ products", true, true, true, false},
                                        {"  of truth", true, true, true, true}}};

// Rigid-body Abbe correction with the spots as declared, which move as the cube does.
std::array<double, 3> corrected_mm(const MicroNanoRow& row) {
  const auto& p = row.path_mm;
  const double rx = row.r_arcsec[0] * kRadPerArcsec, ry = row.r_arcsec[1] * kRadPerArcsec,
               rz = row.r_arcsec[2] * kRadPerArcsec;
  return {p[0] - ry * (-3 - p[2]) + rz * (0 - p[1]), p[1] - rz * (6 - p[0]) + rx * (-3 - p[2]),
          p[2] - rx * (-1 - p[1]) + ry * (2 - p[0])};
}

std::vector<double> terms(const MicroNanoRow& row, const Model& model) {
  const auto pose = model.truth ? row.true_mm : corrected_mm(row);
  std::vector<double> out;
  for (int i = 0; i <= 3; ++i) {
    for (int j = 0; i + j <= 3; ++j) {
      for (int k = 0; i + j + k <= 3; ++k) {
        if (i + j + k > 0) {
          out.push_back(std::pow(pose[0], i) * std::pow(pose[1], j) * std::pow(pose[2] - 1.25, k));
        }
      }
    }
  }
  // Three forces in the calibration grids: F^3 would be a combination of F and F^2.
  if (model.force) out.insert(out.end(), {row.force_n, row.force_n * row.force_n});
  if (model.temperatures) out.insert(out.end(), row.t_degc.begin() + 3, row.t_degc.end());
  if (!model.products) return out;
  for (std::size_t k = 0; k < 3; ++k) {
    out.push_back(row.force_n * pose[k]);
    out.push_back(row.t_degc[9] * pose[k]);
    for (std::size_t l = 0; l <= k; ++l) out.push_back(row.force_n * pose[k] * pose[l]);
  }
  return out;
}

struct Figures {
  std::array<double, 3> inside_nm{}, outside_nm{};
};

Figures figures_of(const std::vector<MicroNanoRow>& rows, const Model& model) {
  Figures figures;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<std::vector<double>> design;
    std::vector<double> q_nm;
    const auto q = [&](const MicroNanoRow& row) {
      return (model.truth ? row.true_q_mm : row.q_mm)[axis] * simulated::kNmPerMm;
    };
    for (const auto& row : rows) {
      if (!row.calibration) continue;
      design.push_back(terms(row, model));
      q_nm.push_back(q(row));
    }
    const LeastSquares fit(design, q_nm);
    std::array<std::vector<double>, 2> errors_nm;
    for (const auto& row : rows) {
      if (row.calibration) continue;
      errors_nm[row.grid == 2 ? 0 : 1].push_back(q(row) - fit.predicted(terms(row, model)));
    }
    figures.inside_nm[axis] = u90(errors_nm[0]);
    figures.outside_nm[axis] = u90(errors_nm[1]);
  }
  return figures;
}

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

TEST(MicroNanoFit, EverySourceOfInaccuracyCountsAndNothingElseIsLeft) {
  constexpr int kSeeds = 10;
  std::array<std::array<std::vector<double>, 3>, kModels.size()> inside, outside;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto rows = run_micro_nano_campaign(DRIFTWISE_SOURCE_DIR, {.seed = seed});
    for (std::size_t m = 0; m < kModels.size(); ++m) {
      const Figures figures = figures_of(rows, kModels[m]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        inside[m][axis].push_back(figures.inside_nm[axis]);
        outside[m][axis].push_back(figures.outside_nm[axis]);
      }
    }
  }
  std::printf("S90 on validation, nm, median of %d seeds, q1 q2 q3; outside: force beyond range\n",
              kSeeds);
  std::array<std::array<double, 3>, kModels.size()> found{};
  for (std::size_t m = 0; m < kModels.size(); ++m) {
    for (std::size_t axis = 0; axis < 3; ++axis) found[m][axis] = median_of(inside[m][axis]);
    std::printf("%-10s  %6.1f %6.1f %6.1f   outside  %6.1f %6.1f %6.1f\n", kModels[m].name,
                found[m][0], found[m][1], found[m][2], median_of(outside[m][0]),
                median_of(outside[m][1]), median_of(outside[m][2]));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_LT(found[3][axis], found[0][axis]) << "force and temperatures explain something";
    EXPECT_LT(found[3][axis], found[1][axis]);
    EXPECT_LT(found[3][axis], found[2][axis]);
    EXPECT_LT(found[4][axis], found[3][axis]) << "force acts differently from place to place";
    // The instruments' own errors stand between the measured pose and the true one.
    EXPECT_GT(found[4][axis], 0.9 * found[5][axis]);
    EXPECT_LT(found[4][axis], 60) << "nothing large is hidden from these terms";
  }
}

}  // namespace
}  // namespace driftwise::testing_support
