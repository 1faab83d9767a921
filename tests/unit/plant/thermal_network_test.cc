#include "drivers/simulated/plant/thermal/thermal_network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "drivers/simulated/plant/thermal/matrix_exponential.h"

namespace driftwise::simulated {
namespace {

PartParameters part(const char* name, double capacity_j_k, double film_w_k = 0, int air = kRoom) {
  return {.name = name, .capacity_j_k = capacity_j_k, .film_w_k = film_w_k, .air = air};
}

TEST(MatrixExponential, TurnsAQuarterForAQuarterOfARotation) {
  const double quarter = std::acos(-1.0) / 2;
  const auto turned = matrix_exponential({0, -quarter, quarter, 0}, 2);
  EXPECT_NEAR(turned[0], 0, 1e-14);
  EXPECT_NEAR(turned[1], -1, 1e-14);
  EXPECT_NEAR(turned[2], 1, 1e-14);
}

TEST(ThermalNetwork, RelaxesTwoNodesAsTheAnalyticSolution) {
  // Alone in the world: the mean by capacity stays, the difference decays at G (1/C1 + 1/C2).
  const std::vector<PartParameters> parts{part("a", 300), part("b", 700)};
  const std::vector<LinkParameters> links{
      {.name = "ab", .from = 0, .to = 1, .conductance_w_k = 2.5}};
  ThermalNetwork network(parts, links, 0.1, 20);
  NodeTemperatures power_w{};
  power_w[0] = 50;  // 10 s of 50 W
  for (int k = 0; k < 100; ++k) network.step(0, power_w);
  EXPECT_NEAR(300 * network.degc()[0] + 700 * network.degc()[1], 20'000 + 500, 1e-8);

  const double difference_k = network.degc()[0] - network.degc()[1];
  power_w[0] = 0;
  for (int k = 0; k < 600; ++k) network.step(0, power_w);
  const double rate_per_s = 2.5 * (1 / 300.0 + 1 / 700.0);
  EXPECT_NEAR(network.degc()[0] - network.degc()[1], difference_k * std::exp(-rate_per_s * 60),
              1e-10);
}

TEST(ThermalNetwork, SettlesWhereHeatInEqualsHeatOut) {
  // 3 W into a, through 1.5 W/K to b, whose film leads to the room by 0.5 W/K: b 6 K and a 8 K
  // above the room.
  const std::vector<PartParameters> parts{part("a", 40), part("b", 60, 0.5)};
  const std::vector<LinkParameters> links{
      {.name = "ab", .from = 0, .to = 1, .conductance_w_k = 1.5}};
  ThermalNetwork network(parts, links, 1, 20);
  NodeTemperatures power_w{};
  power_w[0] = 3;
  for (int k = 0; k < 20'000; ++k) network.step(20, power_w);
  EXPECT_NEAR(network.degc()[1], 26, 1e-9);
  EXPECT_NEAR(network.degc()[0], 28, 1e-9);
}

TEST(ThermalNetwork, GivesTheSameForOneLongStepAndManyShortOnes) {
  const std::vector<PartParameters> parts{part("a", 40), part("b", 5, 0.5)};
  const std::vector<LinkParameters> links{
      {.name = "ab", .from = 0, .to = 1, .conductance_w_k = 12}};
  ThermalNetwork fine(parts, links, 0.1, 20);
  ThermalNetwork coarse(parts, links, 60, 20);
  const NodeTemperatures none{};
  for (int k = 0; k < 600; ++k) fine.step(25, none);
  coarse.step(25, none);
  EXPECT_NEAR(fine.degc()[0], coarse.degc()[0], 1e-10);
  EXPECT_NEAR(fine.degc()[1], coarse.degc()[1], 1e-10);
}

TEST(ThermalNetwork, LosesToAnAirNodeWhatTheAirGains) {
  // b's film leads to node a: nothing leaves.
  const std::vector<PartParameters> parts{part("air", 290), part("b", 60, 0.5, 0)};
  ThermalNetwork network(parts, {}, 0.5, 20);
  NodeTemperatures power_w{};
  power_w[1] = 2;
  for (int k = 0; k < 100; ++k) network.step(0, power_w);
  EXPECT_NEAR(290 * (network.degc()[0] - 20) + 60 * (network.degc()[1] - 20), 100, 1e-9);
}

}  // namespace
}  // namespace driftwise::simulated
