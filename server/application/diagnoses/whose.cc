#include "server/application/diagnoses/whose.h"

#include <algorithm>
#include <array>

#include "server/core/channel.h"

namespace driftwise::application {
namespace {

constexpr std::array<std::string_view, 6> kOfInstruments = {
    "abbe_offset",      "cosine_error",         "refractive_index",
    "instrument_drift", "periodic_disturbance", "step_change"};
constexpr std::array<std::string_view, 4> kOfRows = {"outliers", "sensor_fault", "noise_change",
                                                     "probe_hysteresis"};

}  // namespace

std::string_view to_string(Side side) {
  switch (side) {
    case Side::robot:
      return "robot";
    case Side::instrument:
      return "instrument";
    case Side::rows:
      return "rows";
  }
  return "";
}

Side side_of(std::string_view name) {
  const auto space = name.find(' ');
  const auto id = name.substr(0, space);
  if (std::ranges::find(kOfRows, id) != kOfRows.end()) return Side::rows;
  if (std::ranges::find(kOfInstruments, id) != kOfInstruments.end()) return Side::instrument;
  if (id != "cyclic_error" || space == std::string_view::npos) return Side::robot;
  // A motor's own scale is the robot's; a coordinate of the pose is read by an instrument.
  return is_motor_symbol(without_robot(name.substr(space + 1))) ? Side::robot : Side::instrument;
}

std::string name_of(const diagnosis::Finding& finding) {
  return finding.cause + (finding.subject.empty() ? "" : " " + finding.subject);
}

std::vector<std::string> rivals_across(const diagnosis::Finding& finding) {
  std::vector<std::string> across;
  const Side own = side_of(name_of(finding));
  for (const auto& rival : finding.indistinguishable_from) {
    // A wave that a polynomial of the geometry can be taken for is as long as the travel: scales
    // and lasers have none.
    if (finding.cause == "geometry_order" && rival.starts_with("cyclic_error ")) continue;
    if (const Side side = side_of(rival); side != own && side != Side::rows && own != Side::rows)
      across.push_back(rival);
  }
  return across;
}

}  // namespace driftwise::application
