#include "server/compensation/correction_parts.h"

#include <array>
#include <cmath>
#include <cstdint>

#include "server/compensation/basis_values.h"

namespace driftwise::compensation {
namespace {

constexpr double kFollows = 0.05;  // of the slope

// q1: x, q2: y, q3: z.
std::optional<Variable> wanted_of(const Channel& motor) {
  if (motor.symbol == "q1") return Variable::x;
  if (motor.symbol == "q2") return Variable::y;
  if (motor.symbol == "q3") return Variable::z;
  return std::nullopt;
}

double constant_part(const Snapshot::Output& served, std::size_t entry) {
  return served.coefficients_mm[entry] -
         (served.thermal_mm.empty() ? 0.0 : served.thermal_mm[entry]);
}

// The entry of the basis that is a coordinate of the pose by itself.
bool is_first_degree(const Snapshot& snapshot, std::size_t entry) {
  return entry > 0 && snapshot.products[entry - 1].base == 0 &&
         snapshot.products[entry - 1].variable != static_cast<std::uint8_t>(Variable::force);
}

// Whether the motor follows the wanted coordinate of its number: mm per mm.
bool follows(const Snapshot& snapshot, const Snapshot::Output& served, Variable wanted) {
  bool along = false;
  for (std::size_t k = 1; k < snapshot.basis_size(); ++k) {
    const std::uint8_t variable = snapshot.products[k - 1].variable;
    if (!is_first_degree(snapshot, k) || variable > static_cast<std::uint8_t>(Variable::z))
      continue;
    const double slope = constant_part(served, k) * snapshot.column_per_unit[variable];
    const bool own = variable == static_cast<std::uint8_t>(wanted);
    if (std::abs(slope - (own ? 1.0 : 0.0)) > kFollows) return false;
    along = along || own;
  }
  return along;
}

}  // namespace

std::optional<CorrectionParts> correction_parts(const Snapshot& snapshot,
                                                const TargetRequest& request, std::size_t output) {
  if (output >= snapshot.outputs.size() || snapshot.geometry) return std::nullopt;
  const auto& served = snapshot.outputs[output];
  if ((snapshot.needed & ~request.given) != 0) return std::nullopt;
  const auto wanted = wanted_of(served.channel);
  const bool direct =
      wanted && (request.given & bit(*wanted)) != 0 && follows(snapshot, served, *wanted);
  Basis basis;
  fill_basis(snapshot, request, basis);
  std::array<bool, kMaxBasis> with_force{};
  for (std::size_t k = 0; k < snapshot.products.size(); ++k)
    with_force[k + 1] = with_force[snapshot.products[k].base] ||
                        snapshot.products[k].variable == static_cast<std::uint8_t>(Variable::force);
  CorrectionParts parts;
  // The wanted coordinate comes off the constant first: what is left are small numbers.
  if (direct) parts.geometry_nm = -kNmPerMm * request.value[static_cast<std::size_t>(*wanted)];
  bool pose = direct;
  for (std::size_t k = 0; k < snapshot.basis_size(); ++k) {
    const double constant = constant_part(served, k);
    pose = pose || is_first_degree(snapshot, k);
    parts.temperatures_nm += kNmPerMm * (served.coefficients_mm[k] - constant) * basis.b[k];
    if (!direct && (k == 0 || is_first_degree(snapshot, k))) continue;
    (with_force[k] ? parts.force_nm : parts.geometry_nm) += kNmPerMm * constant * basis.b[k];
  }
  if (!pose || !std::isfinite(parts.sum_nm())) return std::nullopt;
  return parts;
}

}  // namespace driftwise::compensation
