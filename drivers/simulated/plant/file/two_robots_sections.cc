#include "drivers/simulated/plant/file/robot_sections.h"

namespace driftwise::simulated {
namespace {

ContactParameters contact_section(Fields f) {
  ContactParameters contact{.gap_mm = f.within("gap_mm", 0, 10),
                            .tip_at_mm = f.within("tip_at_mm", -10, 10),
                            .gap_spread_mm = f.within("gap_spread_mm", 0, 1),
                            .parallelism_deg = f.within("parallelism_deg", 0, 5),
                            .lever_mm = f.within("lever_mm", 0, 1000),
                            .lever_spread_mm = f.within("lever_spread_mm", 0, 100),
                            .hardness_gpa = f.positive("hardness_gpa"),
                            .tip_radius_nm = f.not_negative("tip_radius_nm"),
                            .recovery = f.within("recovery", 0, 0.9)};
  f.finish();
  return contact;
}

HoldingParameters holding_section(Fields f) {
  HoldingParameters holding{.flexure_n_mm = f.positive("flexure_n_mm"),
                            .dead_zone_nm = f.not_negative("dead_zone_nm"),
                            .servo_n_mm = f.positive("servo_n_mm"),
                            .integral_n_mm_s = f.not_negative("integral_n_mm_s"),
                            .integral_zone_nm = f.not_negative("integral_zone_nm"),
                            .integral_limit_n = f.positive("integral_limit_n")};
  f.finish();
  return holding;
}

MicroscopeParameters microscope_section(Fields f) {
  MicroscopeParameters scope{.scale_x_ppm = f.within("scale_x_ppm", -1e5, 1e5),
                             .scale_y_ppm = f.within("scale_y_ppm", -1e5, 1e5),
                             .fine_pixel_nm = f.positive("fine_pixel_nm"),
                             .fine_marking_px = f.not_negative("fine_marking_px"),
                             .fine_um = f.positive("fine_um"),
                             .coarse_pixel_nm = f.positive("coarse_pixel_nm"),
                             .coarse_marking_px = f.not_negative("coarse_marking_px"),
                             .picture_um = f.positive("picture_um")};
  f.finish();
  return scope;
}

}  // namespace

TwoRobotsParameters two_robots_sections(Fields root) {
  TwoRobotsParameters both;
  Fields head = root.table("plant");
  for (const char* key : {"kind", "upper", "lower"}) head.text(key);
  head.finish();
  both.contact = contact_section(root.table("contact"));
  both.holding = holding_section(root.table("holding"));
  Fields knock = root.table("knock");
  both.knock = {.hz = knock.positive("hz"), .decay_s = knock.positive("decay_s")};
  knock.finish();
  both.microscope = microscope_section(root.table("microscope"));
  root.finish();
  return both;
}

}  // namespace driftwise::simulated
