#pragma once
// The models of case B that are compared, and where the error of each comes from.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/statistics/case_b_campaign.h"

namespace driftwise::statistics {

struct CaseBModel {
  std::string name, formula;
  bool bic = false;  // selected by BIC instead of the partial F test
};
// G, G+F, G+T, G+T+F as published. Then with what force and warmth do to the geometry: force times
// pose, and times the pose the thermometer of the end-effector, every thermometer of the robot, or
// that of the base plate, which carries the axes. The last is what docs/fitting.md recommends.
const std::vector<CaseBModel>& case_b_models();

struct CaseBFigures {  // of one model, by axis; S90 on the validation grid inside the forces, nm
  std::array<double, 3> u90{};
  // The same model's terms fitted to the robot alone and to the instruments' share alone. Least
  // squares is linear, so the errors of the two add up to the model's; their squares nearly so.
  std::array<double, 3> robot_u90{};        // what the terms do not follow
  std::array<double, 3> instruments_u90{};  // noise of the rows, and what it does to coefficients
  std::array<int, 3> terms{};
};
CaseBFigures case_b_figures(const CaseBCampaign& campaign, const CaseBModel& model);

struct CaseBSeed {
  std::uint64_t seed = 0;
  std::vector<CaseBFigures> models;
  std::array<double, 3> robot_oracle{}, terms_oracle{};  // S90, nm: case_b_oracle.h
};
CaseBSeed case_b_seed(std::uint64_t seed, const std::vector<CaseBModel>& models);

// Medians over seeds by axis of what the table says, and of the ratios to both oracles with the
// share of (seed, axis) within 15 %.
std::string case_b_table(const std::vector<CaseBSeed>& seeds,
                         const std::vector<CaseBModel>& models);

double median_of(std::vector<double> values);

// S90 of a model over an oracle's, of every seed and axis.
std::vector<double> ratios(const std::vector<CaseBSeed>& seeds, std::size_t model,
                           std::array<double, 3> CaseBSeed::*oracle);

}  // namespace driftwise::statistics
