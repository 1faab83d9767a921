#include "tests/hidden_effects/joint/two_robot_models.h"

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>

namespace driftwise::plans::joint_use {
namespace {

using compensation::Variable;
using joint_plant::Pose;

// A dataset that grows row by row.
class Table {
 public:
  // measured_by: as a run in its set-up states it (server/core/data/measured_by.h).
  explicit Table(std::vector<Channel> channels, std::string measured_by = {}) {
    if (!measured_by.empty()) data_.metadata = {{kMeasuredByKey, std::move(measured_by)}};
    for (auto& channel : channels) data_.columns.push_back({std::move(channel), {}});
  }
  void add(const std::vector<double>& row, bool calibration = true) {
    for (std::size_t i = 0; i < row.size(); ++i) data_.columns[i].values.push_back(row[i]);
    data_.set.push_back(calibration ? PointSet::calibration : PointSet::validation);
    data_.time_s.push_back(27.0 * static_cast<double>(data_.rows++));
  }
  calibration::Model fitted(std::vector<std::string> outputs, std::vector<effects::Term> terms,
                            calibration::Select select = calibration::Select::stepwise) const {
    calibration::FitOptions options;
    options.candidates.outputs = std::move(outputs);
    options.candidates.terms = std::move(terms);
    options.select = select;
    auto model = calibration::fit(data_, options);
    if (!model) throw std::runtime_error(model.error().message);
    return std::move(*model);
  }

 private:
  Dataset data_;
};

// poly(a, b, c, degree): the products of degree 1 to this, 19 of degree 3.
std::vector<effects::Term> poly(const std::array<std::string, 3>& symbols, int degree) {
  std::vector<effects::Term> terms;
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j)
      for (int k = 0; i + j + k <= degree; ++k) {
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

std::vector<effects::Term> min_angle_terms(Knowledge knowledge) {
  auto terms = poly({"ma.rx", "ma.ry", "ma.z"}, 3);
  if (knowledge == Knowledge::complete) terms.push_back(power("t08"));
  return terms;
}

double height_of(Machine& plant, const Pose& at, Knowledge knowledge) {
  if (knowledge == Knowledge::complete) plant.see.probe_mm(at.z - 5e-3);  // the tip from below
  return plant.see.probe_mm(at.z);
}

// Part 1 of the study's plan: 125 places in motor coordinates, by probe and inclinometer.
calibration::Model coarse_model(Machine& plant, joint_plant::Room room, Knowledge knowledge) {
  Table table({{"ma.q1", "mm"},
               {"ma.q2", "mm"},
               {"ma.q3", "mm"},
               {"ma.rx", "arcsec"},
               {"ma.ry", "arcsec"},
               {"ma.z", "mm"},
               {"t08", "degC"}},
              "ma.z=probe ma.rx=inclinometer ma.ry=inclinometer");
  for (const double q1 : {-4.0, -2.0, 0.0, 2.0, 4.0})
    for (const double q2 : {-4.0, -2.0, 0.0, 2.0, 4.0})
      for (const double q3 : {-4.0, -2.0, 0.0, 2.0, 4.0}) {
        room.advance(20);
        const Pose at = plant.m.pose({q1, q2, q3}, room);
        table.add({q1, q2, q3, plant.see.inclinometer_arcsec(at.rx),
                   plant.see.inclinometer_arcsec(at.ry), height_of(plant, at, knowledge),
                   room.t08()});
      }
  return table.fitted({"ma.q1", "ma.q2", "ma.q3"}, min_angle_terms(knowledge));
}

// Part 2: 343 places within 300 arcsec and 3 mm, by autocollimators and probe.
calibration::Model fine_model(Machine& plant, joint_plant::Room room, Knowledge knowledge) {
  Table table({{"ma.q1", "mm"},
               {"ma.q2", "mm"},
               {"ma.q3", "mm"},
               {"ma.rx", "arcsec"},
               {"ma.ry", "arcsec"},
               {"ma.z", "mm"},
               {"t08", "degC"}},
              "ma.z=probe ma.rx=collimators ma.ry=collimators");
  // One height after the other would rise with the room: what warms and what is high would be one.
  const std::array<int, 7> heights = knowledge == Knowledge::study
                                         ? std::array{-3, -2, -1, 0, 1, 2, 3}
                                         : std::array{0, 3, -2, 1, -3, 2, -1};
  for (const int z : heights)
    for (int rx = -300; rx <= 300; rx += 100)
      for (int ry = -300; ry <= 300; ry += 100) {
        room.advance(16);
        const auto q = joint_plant::MinAngle::read_back(plant.m.motors_at(rx, ry, z, room));
        const Pose at = plant.m.pose(q, room);
        table.add({q[0], q[1], q[2], plant.see.collimator_arcsec(at.rx),
                   plant.see.collimator_arcsec(at.ry), height_of(plant, at, knowledge),
                   room.t08()});
      }
  return table.fitted({"ma.q1", "ma.q2", "ma.q3"}, min_angle_terms(knowledge));
}

// Part 3: 17 heights up and down for five hours in a room that warms, by interferometers; integer
// heights calibrate.
calibration::Model sideways_model(Machine& plant, joint_plant::Room room, Knowledge knowledge) {
  const bool tilted = knowledge == Knowledge::complete;
  std::mt19937_64 random(11);
  const auto tilt = [&] {
    return tilted ? std::uniform_real_distribution<>(-300, 300)(random) : 0.0;
  };
  Table table({{"ma.x", "mm"},
               {"ma.y", "mm"},
               {"ma.z", "mm"},
               {"t09", "degC"},
               {"ma.rx", "arcsec"},
               {"ma.ry", "arcsec"}},
              "ma.x=ma.x-laser ma.y=ma.y-laser ma.z=ma.z-laser ma.rx=collimators "
              "ma.ry=collimators");
  for (int row = 0; row < 664; ++row) {
    room.advance(27);
    const int step = row % 32;
    const double z = 4 - 0.5 * (step <= 16 ? step : 32 - step);
    const double rx = tilt(), ry = tilt();
    const Pose at = tilted ? plant.m.pose(plant.m.motors_at(rx, ry, z, room), room)
                           : plant.m.pose({z, z, z}, room);
    table.add({plant.see.laser_mm(at.x), plant.see.laser_mm(at.y), plant.see.laser_mm(at.z),
               room.t09(), plant.see.collimator_arcsec(at.rx), plant.see.collimator_arcsec(at.ry)},
              step % 2 == 0);
  }
  std::vector<effects::Term> terms = {power("ma.z"), power("ma.z", 2), power("ma.z", 3),
                                      power("t09")};
  if (tilted) terms.insert(terms.end(), {power("ma.rx"), power("ma.ry")});
  return table.fitted({"ma.x", "ma.y"}, std::move(terms));
}

}  // namespace

calibration::Model micro_nano_model(Machine& plant, joint_plant::Room room, bool tilts,
                                    Knowledge knowledge, calibration::Select of_tilts) {
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
  const int degree = knowledge == Knowledge::complete && !tilts ? 4 : 3;
  auto terms = poly({"mn.x", "mn.y", "mn.z"}, degree);
  if (tilts) return table.fitted({"mn.rx", "mn.ry", "mn.rz"}, std::move(terms), of_tilts);
  terms.push_back(power("t05"));
  if (knowledge == Knowledge::complete)
    for (const char* symbol : {"mn.x", "mn.y", "mn.z"})
      terms.push_back({{effects::Power{"t05", 1}, effects::Power{symbol, 1}}});
  const auto select =
      knowledge == Knowledge::complete ? calibration::Select::all : calibration::Select::stepwise;
  return table.fitted({"mn.q1", "mn.q2", "mn.q3"}, std::move(terms), select);
}

CellDescription cell_of_both() {
  CellDescription cell;
  const auto add_length = [&cell](const std::string& id, const char* symbol, double u_nm) {
    auto& device = cell.devices.emplace_back();
    device.id = id;
    auto& length = device.become<LengthSettings>();
    length.channel = {symbol, "mm"};
    length.u_length_nm = u_nm;
  };
  for (const char* symbol : {"mn.x", "mn.y", "mn.z", "ma.x", "ma.y", "ma.z"})
    add_length(std::string(symbol) + "-laser", symbol, 10);
  add_length("probe", "ma.z", 50 / std::sqrt(12));  // the probe, in counts of 50 nm
  const auto add_angles = [&cell](const char* id, std::vector<std::string> symbols,
                                  double u_arcsec) {
    auto& device = cell.devices.emplace_back();
    device.id = id;
    auto& settings = device.become<AngleSettings>();
    for (auto& symbol : symbols) {
      auto& angle = settings.angles.emplace_back();
      angle.channel = {std::move(symbol), "arcsec"};
      angle.u_arcsec = u_arcsec;
    }
  };
  add_angles("collimators", {"mn.rx", "mn.ry", "mn.rz", "ma.rx", "ma.ry"}, 0.05);
  add_angles("inclinometer", {"ma.rx", "ma.ry"},
             std::hypot(10, 36 / std::sqrt(12)));  // the inclinometer
  DeviceDescription scanner;
  scanner.id = "scanner";
  for (const char* name : {"t05", "t08", "t09"}) {
    auto& probe = scanner.become<TemperatureSettings>().probes.emplace_back();
    probe.channel = {name, "degC"};
    probe.u_k = 0.002;
  }
  cell.devices.push_back(scanner);
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

ModelsById models_of(Machine& plant, std::uint64_t seed, Knowledge knowledge) {
  // A temperature is known in the range that it was measured in.
  const bool warms = knowledge == Knowledge::complete;
  return {
      {kCoarseModel, coarse_model(plant, {seed + 1, 19.8, warms ? 21.6 : 20.2, 2.5}, knowledge)},
      {kFineModel,
       fine_model(plant, {seed + 2, warms ? 19.8 : 20.0, warms ? 21.6 : 20.5, 3}, knowledge)},
      {kSideways, sideways_model(plant, {seed + 3, 19.8, 21.3, 5}, knowledge)},
      {kMicroNanoModel, micro_nano_model(plant, {seed + 4, 19.8, 21.3, 5}, false, knowledge)},
      {kTilts, micro_nano_model(plant, {seed + 4, 19.8, 20.2, 1.2}, true, knowledge)}};
}

}  // namespace driftwise::plans::joint_use
