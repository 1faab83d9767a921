// Joint use of two robots at the plant's truth, which the study never measured: ten plants, each
// calibrated by the study's campaigns, then 200 random joint poses in another drifting room, with
// no compensation of parasitic motion, of translations, of tilts, and of both.
//
// Two figures: the vector from the wanted to the real contact point of the work-piece at the
// end-effector's reference point (nm), and the angle between tool axis and work-piece normal less
// the wanted one (arcsec). Root mean square over a plant's poses; differences are paired by plant.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>

#include "server/calibration/fit.h"
#include "server/plans/joint_target.h"
#include "server/plans/plan_check.h"
#include "tests/hidden_effects/joint/two_robot_plant.h"

namespace driftwise::plans {
namespace {

using compensation::Variable;
using joint_plant::Pose;

constexpr ModelId kMicroNanoModel{12}, kFineModel{11}, kCoarseModel{10}, kSideways{13}, kTilts{14};
constexpr int kPlants = 10, kPoses = 200;

// A dataset that grows row by row.
class Table {
 public:
  explicit Table(std::vector<Channel> channels) {
    for (auto& channel : channels) data_.columns.push_back({std::move(channel), {}});
  }
  void add(const std::vector<double>& row, bool calibration = true) {
    for (std::size_t i = 0; i < row.size(); ++i) data_.columns[i].values.push_back(row[i]);
    data_.set.push_back(calibration ? PointSet::calibration : PointSet::validation);
    data_.time_s.push_back(27.0 * static_cast<double>(data_.rows++));
  }
  calibration::Model fitted(std::vector<std::string> outputs,
                            std::vector<effects::Term> terms) const {
    calibration::FitOptions options;
    options.candidates.outputs = std::move(outputs);
    options.candidates.terms = std::move(terms);
    auto model = calibration::fit(data_, options);
    if (!model) throw std::runtime_error(model.error().message);
    return std::move(*model);
  }

 private:
  Dataset data_;
};

// poly(a, b, c, 3): the 19 products of degree 1 to 3.
std::vector<effects::Term> cubic(const std::array<std::string, 3>& symbols) {
  std::vector<effects::Term> terms;
  for (int i = 0; i <= 3; ++i)
    for (int j = 0; i + j <= 3; ++j)
      for (int k = 0; i + j + k <= 3; ++k) {
        effects::Term term;
        const int exponents[] = {i, j, k};
        for (std::size_t s = 0; s < 3; ++s)
          if (exponents[s] > 0) term.factors.emplace_back(effects::Power{symbols[s], exponents[s]});
        if (!term.factors.empty()) terms.push_back(std::move(term));
      }
  return terms;
}

effects::Term power(const char* symbol, int exponent = 1) {
  return {{effects::Power{symbol, exponent}}};
}

struct Machine {
  explicit Machine(std::uint64_t seed) : a(seed), m(seed + 1000), see(seed + 2000) {}
  joint_plant::MicroNano a;
  joint_plant::MinAngle m;
  joint_plant::Instruments see;
};

// Part 1 of the study's plan: 125 places in motor coordinates, by probe and inclinometer.
calibration::Model coarse_model(Machine& plant, joint_plant::Room room) {
  Table table({{"ma.q1", "mm"},
               {"ma.q2", "mm"},
               {"ma.q3", "mm"},
               {"ma.rx", "arcsec"},
               {"ma.ry", "arcsec"},
               {"ma.z", "mm"}});
  for (const double q1 : {-4.0, -2.0, 0.0, 2.0, 4.0})
    for (const double q2 : {-4.0, -2.0, 0.0, 2.0, 4.0})
      for (const double q3 : {-4.0, -2.0, 0.0, 2.0, 4.0}) {
        room.advance(20);
        const Pose at = plant.m.pose({q1, q2, q3}, room);
        table.add({q1, q2, q3, plant.see.inclinometer_arcsec(at.rx),
                   plant.see.inclinometer_arcsec(at.ry), plant.see.probe_mm(at.z)});
      }
  return table.fitted({"ma.q1", "ma.q2", "ma.q3"}, cubic({"ma.rx", "ma.ry", "ma.z"}));
}

// Part 2: 343 places within 300 arcsec and 3 mm, by autocollimators and probe.
calibration::Model fine_model(Machine& plant, joint_plant::Room room) {
  Table table({{"ma.q1", "mm"},
               {"ma.q2", "mm"},
               {"ma.q3", "mm"},
               {"ma.rx", "arcsec"},
               {"ma.ry", "arcsec"},
               {"ma.z", "mm"}});
  for (int z = -3; z <= 3; ++z)
    for (int rx = -300; rx <= 300; rx += 100)
      for (int ry = -300; ry <= 300; ry += 100) {
        room.advance(16);
        const auto q = plant.m.motors_at(rx, ry, z, room);
        const Pose at = plant.m.pose(q, room);
        table.add({q[0], q[1], q[2], plant.see.collimator_arcsec(at.rx),
                   plant.see.collimator_arcsec(at.ry), plant.see.probe_mm(at.z)});
      }
  return table.fitted({"ma.q1", "ma.q2", "ma.q3"}, cubic({"ma.rx", "ma.ry", "ma.z"}));
}

// Part 3: 17 heights up and down for five hours in a room that warms, by interferometers; integer
// heights calibrate.
calibration::Model sideways_model(Machine& plant, joint_plant::Room room) {
  Table table({{"ma.x", "mm"}, {"ma.y", "mm"}, {"ma.z", "mm"}, {"t09", "degC"}});
  for (int row = 0; row < 664; ++row) {
    room.advance(27);
    const int step = row % 32;
    const double z = 4 - 0.5 * (step <= 16 ? step : 32 - step);
    const Pose at = plant.m.pose({z, z, z}, room);
    table.add(
        {plant.see.laser_mm(at.x), plant.see.laser_mm(at.y), plant.see.laser_mm(at.z), room.t09()},
        step % 2 == 0);
  }
  return table.fitted({"ma.x", "ma.y"},
                      {power("ma.z"), power("ma.z", 2), power("ma.z", 3), power("t09")});
}

// The Micro-Nano: four grids of 6^3 in a room that warms by 1.5 K.
calibration::Model micro_nano_model(Machine& plant, joint_plant::Room room, bool tilts) {
  Table table({{"mn.q1", "mm"},
               {"mn.q2", "mm"},
               {"mn.q3", "mm"},
               {"mn.x", "mm"},
               {"mn.y", "mm"},
               {"mn.z", "mm"},
               {"mn.rx", "arcsec"},
               {"mn.ry", "arcsec"},
               {"mn.rz", "arcsec"},
               {"t05", "degC"}});
  for (int grid = 0; grid < (tilts ? 1 : 4); ++grid)
    for (int k = 0; k < 216; ++k) {
      room.advance(20);
      const auto q = plant.a.motors_at(0.5 * (k % 6), 0.5 * (k / 6 % 6), 0.5 * (k / 36), room);
      const Pose at = plant.a.pose(q, room);
      table.add({q[0], q[1], q[2], plant.see.laser_mm(at.x), plant.see.laser_mm(at.y),
                 plant.see.laser_mm(at.z), plant.see.collimator_arcsec(at.rx),
                 plant.see.collimator_arcsec(at.ry), plant.see.collimator_arcsec(at.rz),
                 room.t05()});
    }
  auto terms = cubic({"mn.x", "mn.y", "mn.z"});
  if (tilts) return table.fitted({"mn.rx", "mn.ry", "mn.rz"}, std::move(terms));
  terms.push_back(power("t05"));
  return table.fitted({"mn.q1", "mn.q2", "mn.q3"}, std::move(terms));
}

CellDescription cell_of_both() {
  CellDescription cell;
  DeviceDescription scanner;
  scanner.id = "scanner";
  for (const char* name : {"t05", "t09"}) {
    auto& probe = scanner.become<TemperatureSettings>().probes.emplace_back();
    probe.channel = {name, "degC"};
    probe.u_k = 0.002;
  }
  cell.devices = {scanner};
  cell.serving.max_age_s = 1e9;
  return cell;
}

ServingPlan plan_of(bool translations, bool tilts) {
  ServingPlan plan;
  plan.name = "joint use";
  const Blend blend{kCoarseModel,
                    {{Variable::rx, 300, 350, 1500},
                     {Variable::ry, 300, 350, 1500},
                     {Variable::z, 2.9, 3.0, 3.6}},
                    true};
  plan.robots = {{"mn", kMicroNanoModel, {}, ""}, {"ma", kFineModel, blend, ""}};
  if (translations) plan.steps.push_back({kSideways, "ma", "mn", {Variable::x, Variable::y}});
  if (tilts) plan.steps.push_back({kTilts, "mn", "ma", {Variable::rx, Variable::ry}});
  plan.z_taken_by = "mn";
  return plan;
}

struct Figures {
  double contact_nm = 0, sideways_nm = 0, angle_arcsec = 0;  // root mean squares
};

constexpr double kRadPerArcsec = 4.84813681109536e-6;

// Where the tool meets the work-piece, less where it should, at one joint pose.
struct Contact {
  double x, y, z, angle;
};
Contact contact_of(const Pose& tool, const Pose& piece, const Pose& wanted_tool,
                   const Pose& wanted_piece, const Pose& tool_zero, const Pose& piece_zero) {
  const double drx = (piece.rx - piece_zero.rx) - wanted_piece.rx;
  const double dry = (piece.ry - piece_zero.ry) - wanted_piece.ry;
  const double trx = tool.rx - tool_zero.rx, try_ = tool.ry - tool_zero.ry;
  // The work-piece's own motion at the tool's place: it turns about its centre.
  const double lift = (wanted_tool.y * drx - wanted_tool.x * dry) * kRadPerArcsec;
  return {
      (tool.x - tool_zero.x) - wanted_tool.x - (piece.x - piece_zero.x),
      (tool.y - tool_zero.y) - wanted_tool.y - (piece.y - piece_zero.y),
      (tool.z - tool_zero.z) - wanted_tool.z - ((piece.z - piece_zero.z) - wanted_piece.z) - lift,
      std::hypot(drx - trx, dry - try_)};
}

// The four ways: none, translations, tilts, both.
std::array<Figures, 4> figures_of(std::uint64_t seed) {
  Machine plant(seed);
  const ModelsById models = {
      {kCoarseModel, coarse_model(plant, {seed + 1, 19.8, 20.2, 2.5})},
      {kFineModel, fine_model(plant, {seed + 2, 20.0, 20.5, 3})},
      {kSideways, sideways_model(plant, {seed + 3, 19.8, 21.3, 5})},
      {kMicroNanoModel, micro_nano_model(plant, {seed + 4, 19.8, 21.3, 5}, false)},
      {kTilts, micro_nano_model(plant, {seed + 4, 19.8, 20.2, 1.2}, true)}};
  const CellDescription cell = cell_of_both();
  std::array<Figures, 4> out;
  for (int way = 0; way < 4; ++way) {
    const auto plan = plan_of((way & 1) != 0, (way & 2) != 0);
    const auto check = check_plan(plan, models, {}, cell);
    if (const auto good = check.refusal(); !good) throw std::runtime_error(good.error().message);
    auto builder = JointBuilder::create(plan, PlanId{1}, models, cell);
    if (!builder) throw std::runtime_error(builder.error().message);
    joint_plant::Room room(seed + 5, 20.0, 21.2, 4);
    room.advance(600);
    // The common zero of both robots: motor coordinates there, and every temperature.
    const auto mq = plant.m.motors_at(0, 0, 0, room);
    const auto aq = plant.a.motors_at(0, 0, 0, room);
    const Pose piece_zero = plant.m.pose(mq, room), tool_zero = plant.a.pose(aq, room);
    std::vector<ChannelValue> zero = {{"t05_degC", room.t05()}, {"t09_degC", room.t09()}};
    for (std::size_t i = 0; i < 3; ++i) {
      zero.push_back({"ma.q" + std::to_string(i + 1) + "_mm", mq[i]});
      zero.push_back({"mn.q" + std::to_string(i + 1) + "_mm", aq[i]});
    }
    const auto trouble = builder->anchor(zero, [](ModelId) { return false; });
    if (!trouble.empty()) throw std::runtime_error(trouble.front());
    std::mt19937_64 random(seed + 6);
    const auto within = [&random](double low, double high) {
      return std::uniform_real_distribution<>(low, high)(random);
    };
    double contact = 0, sideways = 0, angle = 0;
    for (int k = 0; k < kPoses; ++k) {
      room.advance(60);
      const CellTime now{static_cast<std::int64_t>(room.now_s() * 1e9)};
      const ChannelValue seen[] = {{"t05_degC", room.t05()}, {"t09_degC", room.t09()}};
      builder->observe(seen, now);
      const Pose tool{within(0, 2.5), within(0, 2.5), within(0, 2.5), 0, 0, 0};
      const Pose piece{0, 0, within(-2.5, 2.5), within(-250, 250), within(-250, 250), 0};
      const auto snapshot = builder->build(now);
      JointRequest request;
      request.now = now;
      request.set(0, Variable::x, tool.x);
      request.set(0, Variable::y, tool.y);
      request.set(0, Variable::z, tool.z);
      request.set(1, Variable::z, piece.z);
      request.set(1, Variable::rx, piece.rx);
      request.set(1, Variable::ry, piece.ry);
      const auto target = compute_joint_target(snapshot, request);
      if (target.refusal != compensation::Refusal::none)
        throw std::runtime_error(joint_refusal_error(snapshot, target).message);
      const Pose real_tool = plant.a.pose({target.q_mm[0], target.q_mm[1], target.q_mm[2]}, room);
      const Pose real_piece = plant.m.pose({target.q_mm[3], target.q_mm[4], target.q_mm[5]}, room);
      const auto at = contact_of(real_tool, real_piece, tool, piece, tool_zero, piece_zero);
      sideways += at.x * at.x + at.y * at.y;
      contact += at.x * at.x + at.y * at.y + at.z * at.z;
      angle += at.angle * at.angle;
    }
    out[static_cast<std::size_t>(way)] = {1e6 * std::sqrt(contact / kPoses),
                                          1e6 * std::sqrt(sideways / kPoses),
                                          std::sqrt(angle / kPoses)};
  }
  return out;
}

// Paired difference with its 95 % interval over the plants (Student, 9 degrees of freedom).
struct Difference {
  double mean, half;
};
Difference paired(const std::vector<double>& before, const std::vector<double>& after) {
  const auto n = static_cast<double>(before.size());
  double mean = 0, squares = 0;
  for (std::size_t i = 0; i < before.size(); ++i) mean += (after[i] - before[i]) / n;
  for (std::size_t i = 0; i < before.size(); ++i)
    squares += std::pow(after[i] - before[i] - mean, 2) / (n - 1);
  return {mean, 2.262 * std::sqrt(squares / n)};
}

TEST(JointUse, GainsByTranslationsInPlaceAndByTiltsInAngleOverTenPlants) {
  constexpr const char* kWays[] = {"none", "translations", "tilts", "both"};
  std::array<std::vector<double>, 4> contact, sideways, angle;
  for (int plant = 0; plant < kPlants; ++plant) {
    const auto figures = figures_of(7000 + 17 * static_cast<std::uint64_t>(plant));
    for (std::size_t way = 0; way < 4; ++way) {
      contact[way].push_back(figures[way].contact_nm);
      sideways[way].push_back(figures[way].sideways_nm);
      angle[way].push_back(figures[way].angle_arcsec);
    }
  }
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  };
  std::printf("%-13s %12s %28s %12s %28s\n", "compensated", "contact nm", "to none (95 %)",
              "angle arcsec", "to none (95 %)");
  for (std::size_t way = 0; way < 4; ++way) {
    const auto c = paired(contact[0], contact[way]), a = paired(angle[0], angle[way]);
    std::printf("%-13s %12.0f %18.0f +- %6.0f %12.2f %18.2f +- %6.2f   sideways %.0f nm\n",
                kWays[way], mean(contact[way]), c.mean, c.half, mean(angle[way]), a.mean, a.half,
                mean(sideways[way]));
  }
  const auto translations = paired(contact[0], contact[1]);
  EXPECT_LT(translations.mean + translations.half, 0) << "translations bring the contact nearer";
  const auto tilts = paired(angle[0], angle[2]);
  EXPECT_LT(tilts.mean + tilts.half, 0) << "tilts bring the axes together";
  // Both: no worse than either alone in its own figure, within the interval over the plants.
  const auto place = paired(sideways[1], sideways[3]);
  EXPECT_LE(place.mean - place.half, 0);
  const auto axes = paired(angle[2], angle[3]);
  EXPECT_LE(axes.mean - axes.half, 0);
  const auto whole = paired(contact[1], contact[3]);
  std::printf(
      "both against translations alone: contact %+.0f +- %.0f nm, sideways %+.0f +- %.0f nm; "
      "against tilts alone: angle %+.3f +- %.3f arcsec\n",
      whole.mean, whole.half, place.mean, place.half, axes.mean, axes.half);
}

}  // namespace
}  // namespace driftwise::plans
