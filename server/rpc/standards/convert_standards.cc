#include "server/rpc/standards/convert_standards.h"

namespace driftwise::rpc {
namespace {

standards::AxisColumns axis_columns_from(const v1::AxisColumns& columns) {
  return {columns.axis().empty() ? "q1" : columns.axis(), columns.target(), columns.measured()};
}

void put_columns(const standards::AxisColumns& columns, v1::AxisColumns& out) {
  out.set_axis(columns.axis);
  out.set_target(columns.target);
  out.set_measured(columns.measured);
}

void put_conditions(const standards::Conditions& conditions, v1::TestConditions& out) {
  if (!is_missing(conditions.duration_s)) out.set_duration_s(conditions.duration_s);
  for (const auto& t : conditions.temperatures) {
    auto& one = *out.add_temperatures();
    one.set_channel(t.channel);
    one.set_first_degc(t.first_degc);
    one.set_last_degc(t.last_degc);
    one.set_min_degc(t.min_degc);
    one.set_max_degc(t.max_degc);
  }
}

template <class Out>
void put_triple(const standards::Iso2302Triple& triple, Out& out) {
  out.set_both_nm(triple.both_nm);
  out.set_up_nm(triple.up_nm);
  out.set_down_nm(triple.down_nm);
}

template <class Out>
void put_side(const standards::Iso2302Side& side, Out& out) {
  out.set_mean_nm(side.mean_nm);
  out.set_s_nm(side.s_nm);
  out.set_r_nm(side.r_nm);
}

template <class Values, class Field>
void put_list(const Values& values, Field& out) {
  for (const auto& value : values) *out.Add() = value;
}

template <class Field>
std::vector<std::string> words_from(const Field& field) {
  return {field.begin(), field.end()};
}

}  // namespace

standards::Iso2302Options options_from(const v1::EvaluateIso2302Request& request) {
  standards::Iso2302Options out;
  out.columns = axis_columns_from(request.columns());
  if (request.approaches() != 0) out.approaches = request.approaches();
  return out;
}

standards::Iso2303Options options_from(const v1::EvaluateIso2303Request& request) {
  standards::Iso2303Options out;
  out.columns = axis_columns_from(request.columns());
  if (request.has_hours()) out.hours = request.hours();
  if (request.has_longest_gap_min()) out.longest_gap_min = request.longest_gap_min();
  if (request.windows_min_size() > 0)
    out.windows_min = {request.windows_min().begin(), request.windows_min().end()};
  return out;
}

standards::Iso9283Options options_from(const v1::EvaluateIso9283Request& request) {
  standards::Iso9283Options out;
  out.command = words_from(request.command());
  out.measured = words_from(request.measured());
  out.rotation_command = words_from(request.rotation_command());
  out.rotation_measured = words_from(request.rotation_measured());
  if (request.pose_count() != 0) out.poses = request.pose_count();
  if (request.cycle_count() != 0) out.cycles = request.cycle_count();
  out.accuracy = !request.repeatability_only();
  return out;
}

void put(const standards::Iso2302& figures, v1::EvaluateIso2302Response& out) {
  put_columns(figures.columns, *out.mutable_columns());
  out.set_approaches(figures.approaches);
  put_triple(figures.a, *out.mutable_a());
  put_triple(figures.r, *out.mutable_r());
  put_triple(figures.e, *out.mutable_e());
  out.set_m_nm(figures.m_nm);
  out.set_b_nm(figures.b_nm);
  out.set_mean_b_nm(figures.mean_b_nm);
  for (const auto& position : figures.positions) {
    auto& one = *out.add_positions();
    one.set_target_mm(position.target_mm);
    put_side(position.up, *one.mutable_up());
    put_side(position.down, *one.mutable_down());
    one.set_mean_nm(position.mean_nm);
    one.set_b_nm(position.reversal_nm);
    one.set_r_nm(position.r_nm);
  }
  put_list(figures.turning_points_mm, *out.mutable_turning_points_mm());
  put_conditions(figures.conditions, *out.mutable_conditions());
  put_list(figures.warnings, *out.mutable_warnings());
}

void put(const standards::Iso2303& figures, v1::EvaluateIso2303Response& out) {
  using Response = v1::EvaluateIso2303Response;
  put_columns(figures.columns, *out.mutable_columns());
  out.set_range_nm(figures.range_nm);
  for (const auto& series : figures.series) {
    auto& one = *out.add_series();
    one.set_target_mm(series.target_mm);
    one.set_side(series.side == standards::ApproachSide::up     ? Response::SIDE_UP
                 : series.side == standards::ApproachSide::down ? Response::SIDE_DOWN
                                                                : Response::SIDE_AT_REST);
    one.set_visit_count(static_cast<std::int64_t>(series.visits));
    one.set_duration_h(series.duration_h);
    one.set_range_nm(series.range_nm);
    if (!is_missing(series.after_60_min_nm)) one.set_after_60_min_nm(series.after_60_min_nm);
    one.set_at_end_nm(series.at_end_nm);
    one.set_slope_nm_per_h(series.slope_nm_per_h);
    for (const auto& window : series.windows) {
      auto& w = *one.add_windows();
      w.set_minutes(window.minutes);
      w.set_range_nm(window.range_nm);
      w.set_from_h(window.from_h);
    }
  }
  put_conditions(figures.conditions, *out.mutable_conditions());
  put_list(figures.warnings, *out.mutable_warnings());
}

void put(const standards::Iso9283& figures, v1::EvaluateIso9283Response& out) {
  put_list(figures.axes, *out.mutable_axes());
  put_list(figures.rotations, *out.mutable_rotations());
  if (!is_missing(figures.worst_ap_nm)) out.set_worst_ap_nm(figures.worst_ap_nm);
  out.set_worst_rp_nm(figures.worst_rp_nm);
  put_list(figures.worst_ap_rotation_arcsec, *out.mutable_worst_ap_rotation_arcsec());
  put_list(figures.worst_rp_rotation_arcsec, *out.mutable_worst_rp_rotation_arcsec());
  for (const auto& pose : figures.poses) {
    auto& one = *out.add_poses();
    put_list(pose.command_mm, *one.mutable_command_mm());
    put_list(pose.rotation_command_arcsec, *one.mutable_rotation_command_arcsec());
    one.set_cycle_count(static_cast<std::int64_t>(pose.cycles));
    if (!is_missing(pose.ap_nm)) one.set_ap_nm(pose.ap_nm);
    put_list(pose.ap_axis_nm, *one.mutable_ap_axis_nm());
    one.set_rp_nm(pose.rp_nm);
    one.set_mean_l_nm(pose.mean_l_nm);
    one.set_s_l_nm(pose.s_l_nm);
    put_list(pose.ap_rotation_arcsec, *one.mutable_ap_rotation_arcsec());
    put_list(pose.rp_rotation_arcsec, *one.mutable_rp_rotation_arcsec());
  }
  put_conditions(figures.conditions, *out.mutable_conditions());
  put_list(figures.warnings, *out.mutable_warnings());
}

}  // namespace driftwise::rpc
