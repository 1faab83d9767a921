#include "clients/cli/pages/budget_table.h"

#include <array>

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"

namespace driftwise::cli {
namespace {

struct SourceText {
  v1::BudgetLine::Source source;
  const char *name, *type, *what;
};
// In the order of docs/uncertainty.md.
constexpr std::array<SourceText, 12> kSources = {{
    {v1::BudgetLine::SOURCE_FIT, "fit", "A", "coefficients, autocorrelation allowed for"},
    {v1::BudgetLine::SOURCE_RESIDUAL, "residual", "A", "of the robot, not followed by the model"},
    {v1::BudgetLine::SOURCE_TEMPERATURES, "temperatures", "B", "certificates, not absorbed"},
    {v1::BudgetLine::SOURCE_LASER, "laser", "B", "reading at the zero"},
    {v1::BudgetLine::SOURCE_DRIFT, "drift", "B", "of the lengths since the zero"},
    {v1::BudgetLine::SOURCE_BEAM_OFFSET, "beam offset", "B", "tilt x lever arm"},
    {v1::BudgetLine::SOURCE_TILTS, "tilts", "B", "autocollimators on known lever arms"},
    {v1::BudgetLine::SOURCE_BEAM_DIRECTION, "beam direction", "B", "squareness"},
    {v1::BudgetLine::SOURCE_MIRROR, "mirror", "B", "flatness"},
    {v1::BudgetLine::SOURCE_FORCE, "force", "B", "of what hangs"},
    {v1::BudgetLine::SOURCE_SCALE, "scale", "B", "reading"},
    {v1::BudgetLine::SOURCE_EXTRAPOLATION, "extrapolation", "", "outside the fitted domain"},
}};

const v1::BudgetLine* line_of(const v1::MotorCoordinate& coordinate,
                              v1::BudgetLine::Source source) {
  for (const auto& line : coordinate.budget())
    if (line.source() == source) return &line;
  return nullptr;
}

}  // namespace

std::string budget_line_name(const v1::BudgetLine& line) {
  for (const auto& source : kSources)
    if (source.source == line.source()) return source.name;
  return "";
}

void print_budget(const Console& console,
                  const google::protobuf::RepeatedPtrField<v1::MotorCoordinate>& coordinates) {
  if (coordinates.empty() || coordinates[0].budget().empty()) return;
  const bool joints = coordinates[0].has_joint();
  std::vector<Table::Column> columns = {{joints ? "u, arcsec" : "u, nm"}, {"type"}};
  for (const auto& coordinate : coordinates)
    columns.push_back(
        {coordinate.channel().substr(0, coordinate.channel().rfind('_')), Align::right});
  columns.push_back({""});
  Table table(columns);
  for (const auto& source : kSources) {
    std::vector<Table::Cell> row = {source.name, source.type};
    bool any = false;
    for (const auto& coordinate : coordinates) {
      const auto* line = line_of(coordinate, source.source);
      any = any || line != nullptr;
      row.push_back(line == nullptr ? "-"
                    : joints        ? fixed(line->u_arcsec(), 3)
                                    : fixed(line->u_nm(), 2));
    }
    row.emplace_back(source.what);
    if (any) table.add(std::move(row));
  }
  std::vector<Table::Cell> combined = {"combined", ""}, expanded = {"expanded", ""};
  for (const auto& coordinate : coordinates) {
    const auto& joint = coordinate.joint();
    combined.push_back(joints ? fixed(joint.u_arcsec(), 3) : fixed(coordinate.u_nm(), 2));
    expanded.push_back(joints ? fixed(joint.expanded_arcsec(), 3)
                              : fixed(coordinate.expanded_nm(), 2));
  }
  expanded.emplace_back("k = 2");
  table.add(std::move(combined));
  table.add(std::move(expanded));
  table.print(console.out, console.paint_out());
}

}  // namespace driftwise::cli
