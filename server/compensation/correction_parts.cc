#include "server/compensation/correction_parts.h"

#include <array>
#include <cmath>

#include "server/compensation/basis_values.h"

namespace driftwise::compensation {
namespace {

// q1: x, q2: y, q3: z.
std::optional<Variable> wanted_of(const Channel& motor) {
  if (motor.symbol == "q1") return Variable::x;
  if (motor.symbol == "q2") return Variable::y;
  if (motor.symbol == "q3") return Variable::z;
  return std::nullopt;
}

}  // namespace

std::optional<CorrectionParts> correction_parts(const Snapshot& snapshot,
                                                const TargetRequest& request, std::size_t output) {
  if (output >= snapshot.outputs.size()) return std::nullopt;
  const auto& served = snapshot.outputs[output];
  const auto wanted = wanted_of(served.channel);
  if (!wanted || (request.given & bit(*wanted)) == 0) return std::nullopt;
  if ((snapshot.needed & ~request.given) != 0) return std::nullopt;
  Basis basis;
  fill_basis(snapshot, request, basis);
  std::array<bool, kMaxBasis> with_force{};
  for (std::size_t k = 0; k < snapshot.products.size(); ++k)
    with_force[k + 1] = with_force[snapshot.products[k].base] ||
                        snapshot.products[k].variable == static_cast<std::uint8_t>(Variable::force);
  CorrectionParts parts;
  // The wanted coordinate comes off the constant first: what is left are small numbers.
  parts.geometry_nm = -kNmPerMm * request.value[static_cast<std::size_t>(*wanted)];
  for (std::size_t k = 0; k < snapshot.basis_size(); ++k) {
    const double thermal = served.thermal_mm.empty() ? 0.0 : served.thermal_mm[k];
    const double rest_nm = kNmPerMm * (served.coefficients_mm[k] - thermal) * basis.b[k];
    (with_force[k] ? parts.force_nm : parts.geometry_nm) += rest_nm;
    parts.temperatures_nm += kNmPerMm * thermal * basis.b[k];
  }
  if (!std::isfinite(parts.sum_nm())) return std::nullopt;
  return parts;
}

}  // namespace driftwise::compensation
