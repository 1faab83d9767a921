#include "server/indentation/indent_table.h"

#include <cmath>
#include <set>

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::indentation {
namespace {

constexpr double kVickers = 0.1891;  // F = HV d^2 / 0.1891: N, mm, kgf/mm^2 (ISO 6507-1)
constexpr double kNmPerUm = 1e3, kUmPerMm = 1e3, kMNPerN = 1e3;

Result<void> check(const Indent& one) {
  const auto bad = [&one](const std::string& what) {
    return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                "indent " + shown(one.id) + ": " + what);
  };
  for (const double value : {one.wanted_um, one.rx_arcsec, one.ry_arcsec, one.measured_um,
                             one.pixel_nm, one.marking_px, one.diagonal_um})
    if (!std::isfinite(value)) return bad("a value is not a number");
  if (!(one.wanted_um > 0))
    return bad("the wanted distance is " + number_text(one.wanted_um) +
               " um, expected above 0: the first indent is no row of its own");
  if (!(one.pixel_nm > 0) || one.marking_px < 0 || one.pictures_joined < 0)
    return bad("pixel " + number_text(one.pixel_nm) + " nm, marking " +
               number_text(one.marking_px) + " px, pictures joined " +
               std::to_string(one.pictures_joined) + ": the first above 0, the others from 0");
  return {};
}

}  // namespace

double vickers_force_mN(double hardness_hv, double diagonal_um) {
  const double diagonal_mm = diagonal_um / kUmPerMm;
  return hardness_hv * diagonal_mm * diagonal_mm / kVickers * kMNPerN;
}

Result<std::vector<IndentRow>> indent_table(std::span<const Indent> indents,
                                            const ToolRules& tool) {
  if (indents.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoRows, "the table holds no indent");
  if (!(tool.lever_mm > 0) || !(tool.hardness_hv > 0) || !std::isfinite(tool.lever_mm) ||
      !std::isfinite(tool.hardness_hv))
    return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                "lever " + number_text(tool.lever_mm) + " mm, hardness " +
                    number_text(tool.hardness_hv) + " HV: both must be finite and above 0");
  std::vector<IndentRow> rows;
  std::set<std::string> seen;
  for (const Indent& one : indents) {
    DRIFTWISE_RETURN_IF_ERROR(check(one));
    if (!seen.insert(one.id).second)
      return fail(ErrorCode::invalid_argument, reasons::kDuplicateId,
                  "indent " + shown(one.id) + " is there twice");
    IndentRow row{.indent = one};
    const double pixel_um = one.pixel_nm / kNmPerUm, joined = one.pictures_joined;
    const double lever_um = tool.lever_mm * kUmPerMm;
    row.error_um = one.measured_um - one.wanted_um;
    row.half_width_um = 2 * one.marking_px * pixel_um + joined * pixel_um / 2;
    // Rectangular distributions: two markings of +-m, joins of +-1/2 pixel each.
    row.u_um = pixel_um * std::sqrt(2 * one.marking_px * one.marking_px / 3 + joined * 0.25 / 3);
    row.rotations_um = lever_um * rad_from_arcsec(std::hypot(one.rx_arcsec, one.ry_arcsec));
    // A rigid tool below the centre, tip at (0, 0, -lever): dx = -lever ry, dy = +lever rx.
    row.lever_um = lever_um * rad_from_arcsec(one.line == Line::x ? -one.ry_arcsec : one.rx_arcsec);
    row.rest_um = row.error_um - row.lever_um;
    row.force_mN = vickers_force_mN(tool.hardness_hv, one.diagonal_um);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace driftwise::indentation
