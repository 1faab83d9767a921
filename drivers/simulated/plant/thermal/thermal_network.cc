#include "drivers/simulated/plant/thermal/thermal_network.h"

#include <algorithm>
#include <cassert>

#include "drivers/simulated/plant/thermal/matrix_exponential.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kRowsAtOnce = 8;
static_assert(kMaxNodes % kRowsAtOnce == 0);

// The rates of T (rows) by T, room and powers, as one square matrix: held inputs are states that do
// not change.
std::vector<double> rates_by_state(std::span<const PartParameters> parts,
                                   std::span<const LinkParameters> links) {
  const std::size_t n = parts.size();
  const std::size_t width = 2 * n + 1;
  std::vector<double> rates(width * width, 0.0);
  const auto join = [&](int from, int to, double conductance_w_k) {
    if (from == kRoom) return;
    const auto row = static_cast<std::size_t>(from);
    const std::size_t column = to == kRoom ? n : static_cast<std::size_t>(to);
    const double rate = conductance_w_k / parts[row].capacity_j_k;
    rates[row * width + row] -= rate;
    rates[row * width + column] += rate;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const auto node = static_cast<int>(i);
    join(node, parts[i].air, parts[i].film_w_k);
    join(parts[i].air, node, parts[i].film_w_k);
    rates[i * width + n + 1 + i] = 1 / parts[i].capacity_j_k;
  }
  for (const auto& link : links) {
    join(link.from, link.to, link.conductance_w_k);
    join(link.to, link.from, link.conductance_w_k);
  }
  return rates;
}

}  // namespace

ThermalNetwork::ThermalNetwork(std::span<const PartParameters> parts,
                               std::span<const LinkParameters> links, double step_s,
                               double start_degc)
    : size_(parts.size()) {
  assert(size_ <= kMaxNodes);
  const std::size_t width = 2 * size_ + 1;
  std::vector<double> rates = rates_by_state(parts, links);
  for (double& rate : rates) rate *= step_s;
  const std::vector<double> grown = matrix_exponential(std::move(rates), width);
  columns_.assign(width * kMaxNodes, 0.0);
  for (std::size_t row = 0; row < size_; ++row) {
    for (std::size_t column = 0; column < width; ++column) {
      columns_[column * kMaxNodes + row] = grown[row * width + column];
    }
  }
  degc_.fill(start_degc);
}

void ThermalNetwork::step(double room_degc, std::span<const double, kMaxNodes> power_w) {
  // Nodes, room, and the few powers that are not zero.
  std::array<const double*, 2 * kMaxNodes + 1> sources;
  std::array<double, 2 * kMaxNodes + 1> factors;
  std::size_t count = 0;
  const auto add = [&](std::size_t column, double factor) {
    sources[count] = columns_.data() + column * kMaxNodes;
    factors[count++] = factor;
  };
  for (std::size_t j = 0; j < size_; ++j) add(j, degc_[j]);
  add(size_, room_degc);
  for (std::size_t j = 0; j < size_; ++j) {
    if (power_w[j] != 0) add(size_ + 1 + j, power_w[j]);
  }
  // A few rows at a time: their sums stay in registers, and no sum is reordered.
  for (std::size_t row = 0; row < size_; row += kRowsAtOnce) {
    std::array<double, kRowsAtOnce> sum{};
    for (std::size_t j = 0; j < count; ++j) {
      for (std::size_t i = 0; i < kRowsAtOnce; ++i) sum[i] += factors[j] * sources[j][row + i];
    }
    std::copy(sum.begin(), sum.end(), degc_.begin() + static_cast<long>(row));
  }
}

}  // namespace driftwise::simulated
