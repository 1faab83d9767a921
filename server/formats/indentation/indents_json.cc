#include "server/formats/indentation/indents_json.h"

#include <nlohmann/json.hpp>

namespace driftwise::formats {
namespace {

using namespace indentation;
using Json = nlohmann::ordered_json;

Json row_json(const IndentRow& row) {
  const Indent& one = row.indent;
  Json json{{"id", one.id},
            {"line", to_string(one.line)},
            {"wanted_um", one.wanted_um},
            {"rx_arcsec", one.rx_arcsec},
            {"ry_arcsec", one.ry_arcsec},
            {"measured_um", one.measured_um},
            {"half_width_um", row.half_width_um},
            {"u_um", row.u_um},
            {"error_um", row.error_um},
            {"rotations_um", row.rotations_um},
            {"lever_um", row.lever_um},
            {"rest_um", row.rest_um}};
  if (row.force_mN > 0) {
    json["diagonal_um"] = one.diagonal_um;
    json["force_mN"] = row.force_mN;
  }
  return json;
}

Json report_json(const TipReport& report) {
  Json lines = Json::array(), curves = Json::array();
  for (const LineFit& fit : report.lines)
    lines.push_back({{"line", to_string(fit.line)},
                     {"indents", fit.indents},
                     {"lever_factor", fit.factor},
                     {"u_lever_factor", fit.u_factor},
                     {"scale_ppm", fit.scale_ppm},
                     {"u_scale_ppm", fit.u_scale_ppm},
                     {"correlation", fit.correlation},
                     {"rms_um", fit.rms_um},
                     {"lever_share", fit.lever_share},
                     {"separable", fit.separable}});
  for (const ErrorCurve& curve : report.curves)
    curves.push_back({{"line", to_string(curve.line)},
                      {"coefficients", curve.coefficients},
                      {"rms_um", curve.rms_um}});
  return {{"lines", lines},
          {"curves", curves},
          {"indistinguishable", report.indistinguishable},
          {"separating", report.separating},
          {"conformity", to_string(report.conformity)},
          {"verdict", report.verdict},
          {"change", report.change}};
}

}  // namespace

std::string indents_json(std::span<const IndentRow> rows, const TipReport& report,
                         const ToolRules& tool) {
  Json json{
      {"driftwise_indents", 1}, {"lever_mm", tool.lever_mm}, {"hardness_hv", tool.hardness_hv}};
  json["indents"] = Json::array();
  for (const IndentRow& row : rows) json["indents"].push_back(row_json(row));
  json.update(report_json(report));
  return json.dump();
}

}  // namespace driftwise::formats
