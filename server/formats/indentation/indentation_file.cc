#include "server/formats/indentation/indentation_file.h"

#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/formats/text/text.h"
#include "server/formats/text/toml_reader.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

constexpr Range kFarthest_mm{.min = -10, .max = 10};
constexpr Range kSize_mm{.min = 0, .max = 1000, .above_min = true};
constexpr double kFarthestPlace_mm = 100;
constexpr std::size_t kTouches = 64, kIndents = 1000;

void read_tool(TomlReader&& reader, IndentationFile& out) {
  reader.text("id", out.rules.tool, Need::required);
  reader.number("lever_mm", out.tool.lever_mm, kSize_mm, Need::required);
  reader.number("hardness_hv", out.tool.hardness_hv, {.min = 1, .max = 5000});
  reader.finish();
}

void read_motion(TomlReader&& reader, IndentationFile& out, TomlProblem& problem) {
  std::string by = "plan";
  reader.choice("by", by, {"plan", "geometry"}, Need::required);
  out.by_plan = by == "plan";
  reader.text("reason", out.reason);
  if (!out.by_plan && out.reason.empty())
    reader.refuse("by", reasons::kReasonRequired,
                  "raw motor coordinates by geometry need a reason = \"...\": why no plan serves "
                  "here");
  const auto robot = [&](const char* key, double& radius_mm, std::vector<double>& azimuth_deg,
                         double* arm_mm) {
    const auto* table = reader.table(key);
    if (table == nullptr) {
      if (!out.by_plan) reader.refuse(key, reasons::kMissingKey, "by = \"geometry\" needs it");
      return;
    }
    TomlReader one(*table, std::string("motion, ") + key, problem);
    one.number("radius_mm", radius_mm, kSize_mm, Need::required);
    if (one.has("azimuth_deg")) one.numbers("azimuth_deg", azimuth_deg, 3);
    if (arm_mm != nullptr) {
      one.number("arm_mm", *arm_mm, kSize_mm, Need::required);
      if (one.has("arm_mm") && !(*arm_mm > radius_mm))
        one.refuse("arm_mm", reasons::kBadValue, "expected longer than radius_mm");
    }
    one.finish();
  };
  robot("above", out.delta.radius_mm, out.delta.azimuth_deg, &out.delta.arm_mm);
  robot("below", out.screws.radius_mm, out.screws.azimuth_deg, nullptr);
  reader.finish();
}

void read_approach(TomlReader&& reader, indentation::ProcedureRules& rules) {
  auto& a = rules.approach;
  reader.number("depart_mm", a.depart_mm, kFarthest_mm, Need::required);
  reader.number("highest_mm", a.highest_mm, kFarthest_mm, Need::required);
  reader.number("step_mm", a.step_mm, {.min = 0, .max = 0.01, .above_min = true});
  reader.integer("most_steps", a.most_steps, 1, 100'000);
  reader.number("threshold_nm", a.contact.threshold_nm, {.min = 1, .max = 1e5});
  reader.number("abort_nm", a.contact.abort_nm, {.min = 1, .max = 1e6});
  reader.integer("baseline_looks", a.contact.baseline_windows, 1, 1000);
  reader.number("clearance_mm", rules.clearance_mm, {.min = 0, .max = 5, .above_min = true});
  reader.number("near_mm", rules.near_mm, {.min = 0, .max = 1, .above_min = true});
  reader.number("press_mm", rules.press_mm, {.min = 0, .max = 0.02});
  reader.number("dwell_s", rules.dwell_s, {.min = 0, .max = 3600});
  reader.number("rest_nm", rules.rest_nm, {.min = 1, .max = 1e5});
  reader.number("rest_change_nm", rules.rest_change_nm, {.min = 0.1, .max = 1e5});
  if (reader.has("depart_mm") && reader.has("highest_mm") && !(a.highest_mm > a.depart_mm))
    reader.refuse("highest_mm", reasons::kBadValue, "expected above depart_mm");
  if (!(a.contact.abort_nm > a.contact.threshold_nm))
    reader.refuse("abort_nm", reasons::kBadValue, "expected above threshold_nm");
  reader.finish();
}

void check_place(TomlReader& reader, const char* key, const std::vector<double>& at_mm) {
  for (const double value : at_mm)
    if (!(std::abs(value) <= kFarthestPlace_mm))
      reader.refuse(key, reasons::kOutOfRange,
                    "found " + number_text(value) + ", expected a place in mm, -100 to 100");
}

void read_align(TomlReader&& reader, indentation::ProcedureRules& rules) {
  std::vector<std::vector<double>> points;
  reader.matrix("points_mm", points);
  if (!points.empty()) {
    if (points.size() < 3 || points.size() > kTouches || points.front().size() != 2)
      reader.refuse("points_mm", reasons::kBadValue, "expected 3 to 64 places [x, y]");
    rules.touch_mm.clear();
    std::vector<indentation::TouchPoint> flat;
    for (const auto& point : points)
      if (point.size() == 2) {
        rules.touch_mm.emplace_back(point[0], point[1]);
        flat.push_back({.x_mm = point[0], .y_mm = point[1], .height_mm = 0, .u_nm = 1});
        check_place(reader, "points_mm", point);
      }
    if (flat.size() >= 3)
      if (const auto plane = indentation::fit_plane(flat); !plane)
        reader.refuse("points_mm", reasons::kPointsOnALine, plane.error().message);
  }
  std::vector<double> shift_um;
  if (reader.has("shift_um")) reader.numbers("shift_um", shift_um, 2);
  if (shift_um.size() == 2) {
    rules.shift_x_mm = shift_um[0] * 1e-3;
    rules.shift_y_mm = shift_um[1] * 1e-3;
  }
  reader.number("accept_nm", rules.alignment.accept_nm, {.min = 1, .max = 1e6});
  reader.integer("most_corrections", rules.alignment.most_corrections, 0, 20);
  reader.finish();
}

void read_indents(TomlReader&& reader, indentation::ProcedureRules& rules) {
  using indentation::Line;
  std::vector<double> at_mm;
  if (reader.has("zero_mm")) reader.numbers("zero_mm", at_mm, 2);
  check_place(reader, "zero_mm", at_mm);
  if (at_mm.size() == 2) {
    rules.zero_x_mm = at_mm[0];
    rules.zero_y_mm = at_mm[1];
  }
  reader.number("work_mm", rules.work_mm, kFarthest_mm);
  reader.number("closed_loop_nm", rules.closed_loop_nm, {.min = 1, .max = 1e4});
  const auto line = [&](const char* key, Line along, bool closed) {
    std::vector<double> places_um;
    reader.numbers(key, places_um);
    for (const double at_um : places_um) {
      if (!(at_um > 0) || at_um > 1e4 || rules.indents.size() >= kIndents)
        reader.refuse(key, reasons::kBadValue, "expected distances above 0 to 10000 um");
      rules.indents.push_back({.id = (along == Line::x ? "x" : "y") + number_text(at_um),
                               .line = along,
                               .at_um = at_um,
                               .closed_loop = closed});
    }
  };
  line("closed_loop_x_um", Line::x, true);
  line("closed_loop_y_um", Line::y, true);
  line("x_um", Line::x, false);
  line("y_um", Line::y, false);
  for (std::size_t i = 0; i < rules.indents.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (rules.indents[i].id == rules.indents[k].id)
        reader.refuse(
            "x_um", reasons::kDuplicateId,
            "the indent at " + number_text(rules.indents[i].at_um) + " um is there twice");
  if (rules.indents.empty())
    reader.refuse("x_um", reasons::kMissingKey,
                  "no indent is wanted, expected such as x_um = [250, 500]");
  reader.finish();
}

}  // namespace

Result<IndentationFile> read_indentation_file(std::string_view text, const std::string& file_name) {
  toml::table root;
  try {
    root = parse_toml(text, file_name);
  } catch (const toml::parse_error& error) {
    return tl::unexpected(syntax_error(error, file_name));
  }
  TomlProblem problem{file_name, {}};
  TomlReader top(root, "", problem);
  IndentationFile out;
  top.text("name", out.name, Need::required);
  top.text("above", out.above);
  top.text("below", out.below);
  if (out.above == out.below)
    top.refuse("below", reasons::kDuplicateId,
               "found " + shown(out.below) +
                   " for above and below, expected two robots: one touches the other");
  top.number("wanted_um", out.wanted_um, {.min = 0, .max = 1000, .above_min = true});
  top.texts("temperatures", out.temperatures);
  top.integer("readings", out.readings, 1, 1000);
  top.integer("poses", out.poses, 1, 1000);
  const auto section = [&](const char* key, auto&& read) {
    if (const auto* table = top.table(key))
      read(TomlReader(*table, key, problem));
    else
      top.refuse(key, reasons::kMissingKey, std::string("expected a section [") + key + "]");
  };
  section("tool", [&](TomlReader&& reader) { read_tool(std::move(reader), out); });
  section("motion", [&](TomlReader&& reader) { read_motion(std::move(reader), out, problem); });
  section("approach", [&](TomlReader&& reader) { read_approach(std::move(reader), out.rules); });
  if (const auto* table = top.table("align"))
    read_align(TomlReader(*table, "align", problem), out.rules);
  section("indents", [&](TomlReader&& reader) { read_indents(std::move(reader), out.rules); });
  top.finish();
  if (problem.first) return tl::unexpected(*problem.first);
  return out;
}

}  // namespace driftwise::formats
