#include "server/application/provenance/data_questions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/provenance/promotion_questions.h"

namespace driftwise::application {
namespace {

// A robot follows the air of a room over hours: what minutes show of it is next to nothing.
constexpr double kShortCampaign_s = 600;

// An imported robot file has a question of its own (imported_geometry_questions).
bool has_data(const calibration::Model& model) {
  return model.lineage.rows_calibration + model.lineage.rows_validation > 0;
}

// ", with q1_mm from -92 to 94 beyond its soft limits -5 .. 5 mm in 340 rows"; empty: none beyond.
std::string beyond_limits(const Dataset& rows, const CellDescription& cell) {
  std::string text;
  for (const auto& axis : cell.axes()) {
    const auto* column = rows.find(axis.channel.symbol);
    if (column == nullptr || column->channel.unit != axis.channel.unit ||
        !(axis.min_mm < axis.max_mm))
      continue;
    double from = axis.max_mm, to = axis.min_mm;
    std::size_t beyond = 0;
    for (const double value : column->values) {
      if (!std::isfinite(value)) continue;
      from = std::min(from, value), to = std::max(to, value);
      if (value < axis.min_mm || value > axis.max_mm) ++beyond;
    }
    if (beyond == 0) continue;
    text += fmt::format(
        ", {} {} from {:.4g} to {:.4g}, in {} row{} beyond its soft limits {:.6g} "
        ".. {:.6g} {}",
        text.empty() ? "with" : "and", axis.channel.name(), from, to, beyond,
        beyond == 1 ? "" : "s", axis.min_mm, axis.max_mm, axis.channel.unit);
  }
  return text;
}

std::string origin_question(const std::string& what, const std::string& beyond) {
  return fmt::format(
      "this cell did not measure {}{}: instruments and thermometers of the file may be others than "
      "those of the same name here",
      what, beyond);
}

std::string duration_text(double seconds) {
  return seconds < 120 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.0f} min", seconds / 60);
}

bool is_of_robot(const ProbeDescription& probe) { return probe.part == "robot"; }

}  // namespace

std::vector<std::string> origin_questions(const calibration::Model& model,
                                          const std::vector<DataOfModel>& data,
                                          const CellDescription& cell) {
  std::vector<std::string> questions;
  if (!has_data(model)) return questions;
  if (data.empty())
    questions.push_back(
        origin_question(fmt::format("its {} rows, which are a file's",
                                    model.lineage.rows_calibration + model.lineage.rows_validation),
                        ""));
  for (const auto& one : data)
    if (!one.measured_here)
      questions.push_back(
          origin_question(fmt::format("run {}{}, which was imported", one.run.value,
                                      one.name.empty() ? "" : fmt::format(" '{}'", one.name)),
                          one.rows ? beyond_limits(*one.rows, cell) : ""));
  return questions;
}

std::vector<std::string> campaign_questions(const calibration::Model& model,
                                            const std::vector<DataOfModel>& data,
                                            const CellDescription& cell, bool judged_later) {
  std::vector<std::string> questions;
  if (!has_data(model)) return questions;
  const auto used = symbols_used(model);
  std::size_t thermometers = 0, followed = 0;
  for (const auto& device : cell.devices)
    for (const auto& probe : device.probes())
      if (is_of_robot(probe)) {
        ++thermometers;
        if (std::ranges::find(used, probe.channel.symbol) != used.end()) ++followed;
      }
  if (thermometers > 0 && followed == 0)
    questions.push_back(fmt::format(
        "none of its terms reads a thermometer of the robot, and the cell has {}: what the robot "
        "does when it warms is neither in its targets nor in their uncertainty (fit with R)",
        thermometers));
  if (model.lineage.rows_validation == 0 && !judged_later)
    questions.push_back(fmt::format(
        "no row judged it: all {} rows made it, and none was held out (set = validation)",
        model.lineage.rows_calibration));
  double duration_s = 0;
  for (const auto& one : data) {
    if (!one.duration_s) return questions;
    duration_s += *one.duration_s;
  }
  if (!data.empty() && duration_s < kShortCampaign_s)
    questions.push_back(fmt::format(
        "its data were measured within {}: nothing shows what the robot does in the hours after",
        duration_text(duration_s)));
  return questions;
}

}  // namespace driftwise::application
