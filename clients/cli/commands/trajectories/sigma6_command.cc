#include <memory>

#include "clients/cli/commands/trajectories/trajectory_grid_command.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/core/units.h"
#include "server/kinematics/sigma6_plan.h"
#include "server/simulation/planned_rows.h"

namespace driftwise::cli {
namespace {

// Assumed dimensions, mm: the thesis prints none.
constexpr double kStrut_mm = 60, kReach_mm = 30, kSpacing_mm = 40;

struct Sigma6Arguments {
  std::vector<double> pose;  // mm, degrees
};

struct EstimatedStage {
  const kinematics::SigmaStage* stage = nullptr;
  double measure_h = 0;  // of one set-up
  double total_h() const {
    return stage->set_ups * (stage->prepare_h + stage->stabilise_h + measure_h);
  }
};

// Ten seconds of waiting and five of measuring, as published; the moves by the estimator.
EstimatedStage estimated(const kinematics::SigmaStage& stage) {
  const simulation::MotionTimes times{
      .velocity_mm_s = 5, .settle_s = 10, .reading_s = 5, .load_s = 0};
  return {&stage, simulation::point_times(stage.plan, times).total_s / 3600};
}

void print_stages(const Console& console, const std::vector<EstimatedStage>& stages) {
  Table table({{"stage"},
               {"set-ups", Align::right},
               {"points each", Align::right},
               {"estimated, h", Align::right},
               {"published, h", Align::right}});
  double total_h = 0, published_h = 0;
  for (const auto& one : stages) {
    table.add({one.stage->name, std::to_string(one.stage->set_ups),
               std::to_string(one.stage->plan.points.size()), fixed(one.total_h(), 1),
               fixed(one.stage->published_h, 1)});
    total_h += one.total_h();
    published_h += one.stage->published_h;
  }
  table.add({"all", "", "", fixed(total_h, 1), fixed(published_h, 1)});
  table.print(console.out, console.paint_out());
  console.out << "\nestimated: the whole plan on the clock only (10 s wait, 5 s measurement, moves "
                 "at 5 mm/s);\nno Sigma6 was measured or simulated. Dimensions are assumed: struts "
              << fixed(kStrut_mm, 0) << ", reach " << fixed(kReach_mm, 0) << ", spacing "
              << fixed(kSpacing_mm, 0) << " mm.\n";
  for (const auto& one : stages)
    if (!one.stage->assumed.empty())
      console.out << "assumed, " << one.stage->name << ": " << one.stage->assumed << '\n';
}

nlohmann::ordered_json stages_json(const std::vector<EstimatedStage>& stages) {
  nlohmann::ordered_json json{{"schema", "driftwise.sigma6.v1"}};
  json["stages"] = nlohmann::ordered_json::array();
  for (const auto& one : stages)
    json["stages"].push_back({{"stage", one.stage->name},
                              {"set_ups", one.stage->set_ups},
                              {"points", one.stage->plan.points.size()},
                              {"estimated_h", one.total_h()},
                              {"published_h", one.stage->published_h},
                              {"assumed", one.stage->assumed}});
  return json;
}

ExitCode show_pose(const Session& session, const kinematics::SixStruts& robot,
                   const std::vector<double>& given) {
  kinematics::SixPose pose;
  for (Eigen::Index k = 0; k < 3; ++k) {
    pose.position_mm[k] = given[static_cast<std::size_t>(k)];
    pose.rotation_rad[k] = rad_from_arcsec(3600 * given[static_cast<std::size_t>(k + 3)]);
  }
  const auto q = value_or_throw(robot.motors(pose));
  const auto back = value_or_throw(robot.pose(q));
  const double closes_nm = nm_from_mm((back.position_mm - pose.position_mm).norm());
  const auto prism = kinematics::sigma6_prism();
  nlohmann::ordered_json json{
      {"schema", "driftwise.sigma6_pose.v1"}, {"q_mm", q}, {"closes_nm", closes_nm}};
  json["facets"] = nlohmann::ordered_json::array();
  auto& out = session.console.out;
  for (std::size_t i = 0; i < q.size() && !session.console.json; ++i)
    out << "q" << i + 1 << "  " << fixed(q[i], 7) << " mm\n";
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto facet = kinematics::facet_for(prism, 3600 * given[axis + 3]);
    const std::string name = std::string("r") + "xyz"[axis];
    if (session.console.json) {
      json["facets"].push_back(
          facet ? nlohmann::ordered_json{{"axis", name},
                                         {"facet_deg", prism.facets_arcsec[facet->facet] / 3600},
                                         {"reading_arcsec", facet->reading_arcsec}}
                : nlohmann::ordered_json{{"axis", name}, {"unread", facet.error().message}});
    } else if (facet) {
      out << name << "  facet " << fixed(prism.facets_arcsec[facet->facet] / 3600, 1)
          << " deg reads " << signed_fixed(facet->reading_arcsec, 1) << " arcsec\n";
    } else {
      out << name << "  " << facet.error().message << '\n';
    }
  }
  if (session.console.json)
    session.console.print_json(json);
  else
    out << "forward again: " << significant(closes_nm, 2) << " nm from the wanted pose\n";
  return ExitCode::done;
}

ExitCode show_sigma6(const Session& session, const Sigma6Arguments& a) {
  const auto robot = value_or_throw(kinematics::SixStruts::create(
      kinematics::orthogonal_struts(kStrut_mm, kReach_mm, kSpacing_mm)));
  if (!a.pose.empty()) return show_pose(session, robot, a.pose);
  const auto stages = value_or_throw(kinematics::sigma6_stages(robot));
  std::vector<EstimatedStage> timed;
  for (const auto& stage : stages) timed.push_back(estimated(stage));
  if (session.console.json)
    session.console.print_json(stages_json(timed));
  else
    print_stages(session.console, timed);
  return ExitCode::done;
}

}  // namespace

void add_sigma6_command(CLI::App& trajectory, Session& session) {
  auto a = std::make_shared<Sigma6Arguments>();
  CLI::App& command = add_command(
      trajectory, session, "sigma6",
      "The Sigma6's plan with its hours, and its kinematics: six struts, prisms (no cell)",
      [&session, a] { return show_sigma6(session, *a); });
  command
      .add_option("--pose", a->pose,
                  "X Y Z in mm, RX RY RZ in degrees: motor coordinates and the facets that read it")
      ->expected(6);
}

}  // namespace driftwise::cli
