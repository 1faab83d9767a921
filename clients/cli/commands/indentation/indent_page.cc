#include "clients/cli/commands/indentation/indent_page.h"

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "server/formats/indentation/indents_json.h"

namespace driftwise::cli {
namespace {

using namespace indentation;

constexpr double kPercentPerPpm = 1e-4;

void print_report(const Console& console, const TipReport& report) {
  auto& out = console.out;
  out << '\n';
  for (const LineFit& fit : report.lines)
    out << "line " << to_string(fit.line) << ": rms " << fixed(fit.rms_um, 3)
        << " um; tilt carries " << fixed(100 * fit.lever_share, 0)
        << " % of the largest error; lever factor " << fixed(fit.factor, 2) << " +- "
        << fixed(fit.u_factor, 2) << ", scale " << signed_fixed(fit.scale_ppm * kPercentPerPpm, 2)
        << " +- " << fixed(fit.u_scale_ppm * kPercentPerPpm, 2) << " %, correlation of the two "
        << fixed(fit.correlation, 4) << '\n';
  for (const ErrorCurve& curve : report.curves) {
    out << "curve " << to_string(curve.line) << ": error =";
    for (std::size_t k = curve.coefficients.size(); k-- > 0;)
      out << ' ' << significant(curve.coefficients[k], 4)
          << (k > 1   ? " " + std::string(to_string(curve.line)) + "^2 +"
              : k > 0 ? " " + std::string(to_string(curve.line)) + " +"
                      : "");
    out << " um, rms " << fixed(curve.rms_um, 3) << " um; valid for these indents only\n";
  }
  if (!report.indistinguishable.empty()) {
    out << "cannot be told apart by these indents: {";
    for (std::size_t i = 0; i < report.indistinguishable.size(); ++i)
      out << (i > 0 ? ", " : "") << report.indistinguishable[i];
    out << "}. Measurements that would:\n";
    for (const auto& one : report.separating) out << "  - " << one << '\n';
  }
  out << "verdict: " << report.verdict << '\n';
  for (const auto& one : report.change) out << "  - " << one << '\n';
}

}  // namespace

void print_indents(const Console& console, const std::vector<IndentRow>& rows,
                   const TipReport& report, const ToolRules& tool) {
  if (console.json) {
    return console.print_json(
        nlohmann::ordered_json::parse(formats::indents_json(rows, report, tool)));
  }
  Table table({{"indent"},
               {"line"},
               {"wanted um", Align::right},
               {"rx arcsec", Align::right},
               {"ry arcsec", Align::right},
               {"measured um", Align::right},
               {"U um", Align::right},
               {"u um", Align::right},
               {"error um", Align::right},
               {"rotations um", Align::right},
               {"lever um", Align::right},
               {"rest um", Align::right},
               {"force mN", Align::right}});
  for (const IndentRow& row : rows)
    table.add({row.indent.id, std::string(to_string(row.indent.line)),
               significant(row.indent.wanted_um, 6), fixed(row.indent.rx_arcsec, 1),
               fixed(row.indent.ry_arcsec, 1), fixed(row.indent.measured_um, 2),
               fixed(row.half_width_um, 2), fixed(row.u_um, 2), signed_fixed(row.error_um, 2),
               fixed(row.rotations_um, 2), signed_fixed(row.lever_um, 2),
               signed_fixed(row.rest_um, 2), row.force_mN > 0 ? fixed(row.force_mN, 0) : "-"});
  table.print(console.out, console.paint_out());
  console.out
      << "U = 2 m p + k p / 2 (half-widths added); u = p sqrt(2 m^2 / 3 + k / 12); lever of "
      << significant(tool.lever_mm, 4) << " mm\n";
  print_report(console, report);
}

}  // namespace driftwise::cli
