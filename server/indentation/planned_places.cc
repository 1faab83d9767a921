#include "server/indentation/planned_places.h"

#include "server/core/text/shown_text.h"

namespace driftwise::indentation {

std::vector<PlannedPlace> planned_places(const ProcedureRules& rules) {
  constexpr double kMmOfUm = 1e-3;
  std::vector<PlannedPlace> places{{"zero_mm", rules.zero_x_mm, rules.zero_y_mm}};
  for (int k = 0; k <= rules.alignment.most_corrections; ++k)
    for (const auto& [x_mm, y_mm] : rules.touch_mm)
      places.push_back({"[align] point " + number_text(x_mm) + ", " + number_text(y_mm) +
                            (k > 0 ? " after correction " + std::to_string(k) : ""),
                        x_mm + k * rules.shift_x_mm, y_mm + k * rules.shift_y_mm});
  for (const PlannedIndent& one : rules.indents) {
    const double way_mm = one.at_um * kMmOfUm;
    places.push_back({"indent " + one.id, rules.zero_x_mm + (one.line == Line::x ? way_mm : 0),
                      rules.zero_y_mm + (one.line == Line::y ? way_mm : 0)});
  }
  return places;
}

std::vector<PlannedHeight> planned_heights(const ProcedureRules& rules) {
  const auto& approach = rules.approach;
  return {{"[approach] depart_mm", approach.depart_mm},
          {"[approach] depart_mm - clearance_mm", approach.depart_mm - rules.clearance_mm},
          {"[approach] highest_mm + press_mm", approach.highest_mm + rules.press_mm}};
}

}  // namespace driftwise::indentation
