#include "server/formats/standards/standards_json.h"

namespace driftwise::formats {
namespace {

nlohmann::ordered_json figure_or_null(double value) {
  return is_missing(value) ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
}

nlohmann::ordered_json conditions_json(const standards::Conditions& conditions) {
  nlohmann::ordered_json temperatures = nlohmann::ordered_json::array();
  for (const auto& t : conditions.temperatures)
    temperatures.push_back({{"channel", t.channel},
                            {"first_degC", t.first_degc},
                            {"last_degC", t.last_degc},
                            {"min_degC", t.min_degc},
                            {"max_degC", t.max_degc}});
  return {{"duration_s", figure_or_null(conditions.duration_s)}, {"temperatures", temperatures}};
}

nlohmann::ordered_json triple_json(const standards::Iso2302Triple& triple) {
  return {{"both_nm", triple.both_nm}, {"up_nm", triple.up_nm}, {"down_nm", triple.down_nm}};
}

nlohmann::ordered_json side_json(const standards::Iso2302Side& side) {
  return {{"mean_nm", side.mean_nm}, {"s_nm", side.s_nm}, {"r_nm", side.r_nm}};
}

const char* side_name(standards::ApproachSide side) {
  return side == standards::ApproachSide::up     ? "up"
         : side == standards::ApproachSide::down ? "down"
                                                 : "at_rest";
}

}  // namespace

nlohmann::ordered_json standards_json(const standards::Iso2302& figures) {
  nlohmann::ordered_json positions = nlohmann::ordered_json::array();
  for (const auto& p : figures.positions)
    positions.push_back({{"target_mm", p.target_mm},
                         {"up", side_json(p.up)},
                         {"down", side_json(p.down)},
                         {"mean_nm", p.mean_nm},
                         {"b_nm", p.reversal_nm},
                         {"r_nm", p.r_nm}});
  return {{"schema", "driftwise.iso230-2.v1"},
          {"axis", figures.columns.axis},
          {"target", figures.columns.target},
          {"measured", figures.columns.measured},
          {"approaches", figures.approaches},
          {"a", triple_json(figures.a)},
          {"r", triple_json(figures.r)},
          {"e", triple_json(figures.e)},
          {"m_nm", figures.m_nm},
          {"b_nm", figures.b_nm},
          {"mean_b_nm", figures.mean_b_nm},
          {"positions", positions},
          {"turning_points_mm", figures.turning_points_mm},
          {"conditions", conditions_json(figures.conditions)},
          {"warnings", figures.warnings}};
}

nlohmann::ordered_json standards_json(const standards::Iso2303& figures) {
  nlohmann::ordered_json series = nlohmann::ordered_json::array();
  for (const auto& s : figures.series) {
    nlohmann::ordered_json windows = nlohmann::ordered_json::array();
    for (const auto& w : s.windows)
      windows.push_back({{"minutes", w.minutes}, {"range_nm", w.range_nm}, {"from_h", w.from_h}});
    series.push_back({{"target_mm", s.target_mm},
                      {"side", side_name(s.side)},
                      {"visits", s.visits},
                      {"duration_h", s.duration_h},
                      {"range_nm", s.range_nm},
                      {"after_60_min_nm", figure_or_null(s.after_60_min_nm)},
                      {"at_end_nm", s.at_end_nm},
                      {"slope_nm_per_h", s.slope_nm_per_h},
                      {"windows", windows}});
  }
  return {{"schema", "driftwise.iso230-3.v1"},
          {"axis", figures.columns.axis},
          {"target", figures.columns.target},
          {"measured", figures.columns.measured},
          {"range_nm", figures.range_nm},
          {"series", series},
          {"conditions", conditions_json(figures.conditions)},
          {"warnings", figures.warnings}};
}

nlohmann::ordered_json standards_json(const standards::Iso9283& figures) {
  nlohmann::ordered_json poses = nlohmann::ordered_json::array();
  for (const auto& p : figures.poses)
    poses.push_back({{"command_mm", p.command_mm},
                     {"rotation_command_arcsec", p.rotation_command_arcsec},
                     {"cycles", p.cycles},
                     {"ap_nm", figure_or_null(p.ap_nm)},
                     {"ap_axis_nm", p.ap_axis_nm},
                     {"rp_nm", p.rp_nm},
                     {"mean_l_nm", p.mean_l_nm},
                     {"s_l_nm", p.s_l_nm},
                     {"ap_rotation_arcsec", p.ap_rotation_arcsec},
                     {"rp_rotation_arcsec", p.rp_rotation_arcsec}});
  return {{"schema", "driftwise.iso9283.v1"},
          {"axes", figures.axes},
          {"rotations", figures.rotations},
          {"worst_ap_nm", figure_or_null(figures.worst_ap_nm)},
          {"worst_rp_nm", figures.worst_rp_nm},
          {"worst_ap_rotation_arcsec", figures.worst_ap_rotation_arcsec},
          {"worst_rp_rotation_arcsec", figures.worst_rp_rotation_arcsec},
          {"poses", poses},
          {"conditions", conditions_json(figures.conditions)},
          {"warnings", figures.warnings}};
}

}  // namespace driftwise::formats
