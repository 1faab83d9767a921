#include "server/formats/standards/standards_page.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace driftwise::formats {
namespace {

[[gnu::format(printf, 2, 3)]] void add_text(std::string& out, const char* format, ...) {
  char text[256];
  va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  out += text;
}

// One decimal is enough beside numbers of nanometres, more where they are small.
std::string nm_text(double value) {
  if (is_missing(value)) return "-";
  char text[40];
  std::snprintf(text, sizeof text, std::abs(value) < 10 ? "%.2f" : "%.1f", value);
  return text;
}

void print_conditions(std::string& out, const standards::Conditions& conditions,
                      const std::vector<std::string>& warnings) {
  out += "\nConditions\n";
  if (!is_missing(conditions.duration_s)) add_text(out, "  %.2f h\n", conditions.duration_s / 3600);
  for (const auto& t : conditions.temperatures)
    add_text(out, "  %-12s %8.3f .. %.3f degC, from %.3f to %.3f\n", t.channel.c_str(), t.min_degc,
             t.max_degc, t.first_degc, t.last_degc);
  if (conditions.temperatures.empty()) out += "  no temperature was recorded\n";
  out += "  nothing is corrected to 20 degC; the instruments' uncertainty is not taken off\n";
  for (const auto& warning : warnings) out += "warning: " + warning + "\n";
}

void print_triple(std::string& out, const char* what, const char* letter,
                  const standards::Iso2302Triple& triple) {
  add_text(out, "  %-34s %s %12s   up %10s   down %10s nm\n", what, letter,
           nm_text(triple.both_nm).c_str(), nm_text(triple.up_nm).c_str(),
           nm_text(triple.down_nm).c_str());
}

std::string numbers_list(const std::vector<double>& values, const char* format) {
  std::string out;
  for (const double value : values) {
    if (!out.empty()) out += ", ";
    add_text(out, format, value);
  }
  return out;
}

}  // namespace

std::string standards_page(const standards::Iso2302& f) {
  std::string out;
  add_text(
      out,
      "ISO 230-2, axis %s: %zu positions, %d approaches from each side (%s measured, %s wanted)\n",
      f.columns.axis.c_str(), f.positions.size(), f.approaches, f.columns.measured.c_str(),
      f.columns.target.c_str());
  print_triple(out, "accuracy", "A", f.a);
  print_triple(out, "repeatability", "R", f.r);
  print_triple(out, "systematic deviation", "E", f.e);
  add_text(out, "  %-34s M %12s nm\n", "range of the mean deviations", nm_text(f.m_nm).c_str());
  add_text(out, "  %-34s B %12s   mean %8s nm\n\n", "reversal", nm_text(f.b_nm).c_str(),
           nm_text(f.mean_b_nm).c_str());
  add_text(out, "%12s %10s %8s %10s %8s %10s %10s %10s\n", "target_mm", "up_nm", "s_nm", "down_nm",
           "s_nm", "mean_nm", "B_nm", "R_nm");
  for (const auto& p : f.positions)
    add_text(out, "%12.6f %10s %8s %10s %8s %10s %10s %10s\n", p.target_mm,
             nm_text(p.up.mean_nm).c_str(), nm_text(p.up.s_nm).c_str(),
             nm_text(p.down.mean_nm).c_str(), nm_text(p.down.s_nm).c_str(),
             nm_text(p.mean_nm).c_str(), nm_text(p.reversal_nm).c_str(), nm_text(p.r_nm).c_str());
  if (!f.turning_points_mm.empty())
    out += "turned round at " + numbers_list(f.turning_points_mm, "%.6g") + " mm\n";
  print_conditions(out, f.conditions, f.warnings);
  return out;
}

std::string standards_page(const standards::Iso2303& f) {
  std::string out;
  add_text(out, "ISO 230-3, axis %s: thermal drift (%s measured, %s wanted)\n",
           f.columns.axis.c_str(), f.columns.measured.c_str(), f.columns.target.c_str());
  add_text(out, "  largest range %s nm\n\n", nm_text(f.range_nm).c_str());
  add_text(out, "%12s %8s %7s %10s %12s %10s %12s\n", "target_mm", "approach", "visits", "range_nm",
           "60_min_nm", "end_nm", "nm_per_h");
  for (const auto& s : f.series) {
    const char* side = s.side == standards::ApproachSide::up     ? "up"
                       : s.side == standards::ApproachSide::down ? "down"
                                                                 : "at rest";
    add_text(out, "%12.6f %8s %7zu %10s %12s %10s %12s\n", s.target_mm, side, s.visits,
             nm_text(s.range_nm).c_str(), nm_text(s.after_60_min_nm).c_str(),
             nm_text(s.at_end_nm).c_str(), nm_text(s.slope_nm_per_h).c_str());
    for (const auto& w : s.windows)
      add_text(out, "%12s worst %g min: %s nm, from %.2f h on\n", "", w.minutes,
               nm_text(w.range_nm).c_str(), w.from_h);
  }
  print_conditions(out, f.conditions, f.warnings);
  return out;
}

std::string standards_page(const standards::Iso9283& f) {
  std::string out;
  const std::size_t cycles = f.poses.empty() ? 0 : f.poses.front().cycles;
  add_text(out, "ISO 9283: %zu poses, %zu cycles\n", f.poses.size(), cycles);
  add_text(out, "  pose accuracy       AP %12s nm (worst pose)\n", nm_text(f.worst_ap_nm).c_str());
  add_text(out, "  pose repeatability  RP %12s nm\n", nm_text(f.worst_rp_nm).c_str());
  for (std::size_t i = 0; i < f.rotations.size(); ++i) {
    if (i < f.worst_ap_rotation_arcsec.size())
      add_text(out, "  %-3s AP %10.3f arcsec", f.rotations[i].c_str(),
               f.worst_ap_rotation_arcsec[i]);
    add_text(out, "  %-3s RP %10.3f arcsec\n", f.rotations[i].c_str(),
             f.worst_rp_rotation_arcsec[i]);
  }
  out += "\npose, wanted mm: AP nm (by axis), RP nm (mean l, S_l)\n";
  for (std::size_t p = 0; p < f.poses.size(); ++p) {
    const auto& pose = f.poses[p];
    add_text(out, "  P%zu (%s): AP %s", p + 1, numbers_list(pose.command_mm, "%.6g").c_str(),
             nm_text(pose.ap_nm).c_str());
    if (!pose.ap_axis_nm.empty()) out += " (" + numbers_list(pose.ap_axis_nm, "%+.1f") + ")";
    add_text(out, ", RP %s (%s, %s)", nm_text(pose.rp_nm).c_str(), nm_text(pose.mean_l_nm).c_str(),
             nm_text(pose.s_l_nm).c_str());
    if (!pose.rp_rotation_arcsec.empty())
      out += "; rotations AP " + numbers_list(pose.ap_rotation_arcsec, "%+.3f") + ", RP " +
             numbers_list(pose.rp_rotation_arcsec, "%.3f") + " arcsec";
    out += "\n";
  }
  print_conditions(out, f.conditions, f.warnings);
  return out;
}

}  // namespace driftwise::formats
