#include "drivers/simulated/plant/micro_nano/micro_nano_plant.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kZ = 2;
constexpr PerArm<Vec3> kOutward{Vec3{-1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}};
constexpr PerArm<Vec3> kFirst{Vec3{0, 1, 0}, Vec3{1, 0, 0}, Vec3{1, 0, 0}};
constexpr PerArm<Vec3> kSecond{Vec3{0, 0, 1}, Vec3{0, 0, 1}, Vec3{0, 1, 0}};

NodeTemperatures all_at(double degc) {
  NodeTemperatures nodes{};
  nodes.fill(degc);
  return nodes;
}

std::uint64_t machine_seed(const MicroNanoParameters& p, std::uint64_t seed) {
  return p.machine != 0 ? p.machine : seed;
}

// The machine with what is hidden in the places of its beams.
Machine machine_of(const MicroNanoParameters& p, std::uint64_t seed) {
  Machine machine = made_machine(p, machine_seed(p, seed));
  for (const auto& one : p.hidden) {
    const auto* beam = std::get_if<HiddenBeamPlace>(&one.effect);
    if (beam == nullptr) continue;
    const auto axis = static_cast<std::size_t>(beam->beam);
    machine.spot_error_mm[axis][0] += beam->u_mm;
    machine.spot_error_mm[axis][1] += beam->v_mm;
    machine.beam_error_rad[axis] =
        machine.beam_error_rad[axis] + (beam->angle_arcsec * kRadPerArcsec) * kFirst[axis];
  }
  return machine;
}

}  // namespace

MicroNanoPlant::MicroNanoPlant(MicroNanoParameters parameters, std::uint64_t seed, TimeNs epoch)
    : CellPlant(std::make_unique<const MicroNanoParameters>(std::move(parameters)), seed, epoch),
      parameters_(static_cast<const MicroNanoParameters&>(cell())),
      machine_(machine_of(parameters_, seed)),
      mechanics_(parameters_, machine_),
      load_(parameters_.load, parameters_.load.pulley_height_mm) {
  const auto cold = all_at(parameters_.reference_degc);
  const auto posed = [&](double stage_mm) {
    const auto assembly = mechanics_.assembly({stage_mm, stage_mm, stage_mm}, cold);
    return mechanics_.pulled(assembly, assembly.stiff.centre_mm, {});
  };
  const PlatformPose zero = posed(0);
  reference_centre_mm_ = mechanics_.on_platform(zero, parameters_.cube.centre_mm, cold);
  reference_turn_ = inverse(zero.turn);
  pulley_mm_ = wire_end_mm(posed(parameters_.delta.neutral_mm), cold) +
               Vec3{0, 0, parameters_.load.pulley_height_mm};
  for (std::size_t i = 0; i < collimator_faults_.size(); ++i) {
    angle_noise_.emplace_back(seed, stream_of("collimator.reading", static_cast<int>(i)));
  }
  const double wire_mm = instant(0).wire_mm;
  load_ = LoadRig(parameters_.load, wire_mm);
  recent_.forget();
  zero_at_start();
}

Vec3 MicroNanoPlant::wire_end_mm(const PlatformPose& pose, const NodeTemperatures& degc) const {
  return mechanics_.on_platform(pose, parameters_.load.attach_mm, degc);
}

const MicroNanoPlant::Instant& MicroNanoPlant::instant(double time_s) const {
  return recent_.at(time_s, now_, [this](Instant& one) { solve(one); });
}

void MicroNanoPlant::solve(Instant& i) const {
  const double time_s = i.time_s;
  i.frame = world_.at(time_s);
  PerArm<double> stage_mm{};
  for (std::size_t k = 0; k < kArms; ++k) {
    i.servo[k] = axes_[k].at(time_s, i.frame.hold_wander_nm[k]);
    stage_mm[k] = mechanics_.stage_from_scale_mm(k, i.servo[k].scale_mm, i.frame.degc);
    // The servo follows the scale, so an error of the scale moves the stage the other way.
    stage_mm[k] -= disturbed(DisturbancePlace::scale_nm, {.time_s = time_s,
                                                          .index = static_cast<int>(k),
                                                          .stage_mm = stage_mm[k],
                                                          .approach = i.servo[k].approach,
                                                          .since_move_s = i.servo[k].since_end_s}) /
                   kNmPerMm;
    if (parameters_.hidden.empty()) continue;
    stage_mm[k] += hidden_stage_nm(static_cast<int>(k), i.frame,
                                   {.time_s = time_s,
                                    .stage_mm = i.servo[k].scale_mm,
                                    .force_n = hidden_force_n(time_s)}) /
                   kNmPerMm;
  }
  const auto assembly = mechanics_.assembly(stage_mm, i.frame.degc);
  const Vec3 end_mm = wire_end_mm(assembly.stiff, i.frame.degc);
  const Vec3 wire = pulley_mm_ - end_mm;
  i.wire_mm = norm(wire);
  i.tension_n = load_.tension_n(time_s, i.wire_mm);
  const PlatformPose pose = mechanics_.pulled(assembly, end_mm, i.tension_n * unit(wire));
  i.cube = pose.turn * reference_turn_;
  i.centre_mm = mechanics_.on_platform(pose, parameters_.cube.centre_mm, i.frame.degc);
  if (!disturbances_.empty()) {
    auto centre = to_array(i.centre_mm);
    for (std::size_t k = 0; k < kArms; ++k) {
      centre[k] +=
          disturbed(DisturbancePlace::end_effector_nm, {.time_s = time_s,
                                                        .index = static_cast<int>(k),
                                                        .stage_mm = stage_mm[k],
                                                        .approach = i.servo[k].approach,
                                                        .since_move_s = i.servo[k].since_end_s}) /
          kNmPerMm;
    }
    i.centre_mm = to_vec3(centre);
  }
}

MicroNanoPlant::CubePose MicroNanoPlant::cube_pose(double time_s) const {
  const Instant& at = instant(time_s);
  return {.centre_mm = at.centre_mm - reference_centre_mm_, .turn_rad = rotation_vector(at.cube)};
}

CubeFace MicroNanoPlant::face(std::size_t axis, const Instant& at) const {
  const auto& mirror = machine_.mirrors[axis];
  const double half_mm = parameters_.cube.edge_mm / 2;
  return {.middle_mm = at.centre_mm + half_mm * (at.cube * kOutward[axis]),
          .normal = at.cube * mirror.normal,
          .first = at.cube * kFirst[axis],
          .second = at.cube * kSecond[axis],
          .half_edge_mm = half_mm,
          .figure_nm = mirror.figure};
}

// From the head to the cube as if straight. The head stands where its dead path ends at the zero
// pose; what its support's warmth does to it is added to the path.
LightRay MicroNanoPlant::ray(std::size_t axis, const Instant& at) const {
  const auto& nominal = parameters_.beams[axis];
  const auto& error = machine_.spot_error_mm[axis];
  const double dead_mm = parameters_.interferometers[axis].dead_path_mm;
  const Vec3 spot = reference_centre_mm_ + (parameters_.cube.edge_mm / 2) * kOutward[axis] +
                    (nominal.offset_u_mm + error[0]) * kFirst[axis] +
                    (nominal.offset_v_mm + error[1]) * kSecond[axis];
  const Vec3 aligned = -1.0 * machine_.mirrors[axis].normal;
  if (axis != kZ) {
    const Vec3 along = unit(aligned + machine_.beam_error_rad[axis]);
    return {.from_mm = spot - dead_mm * along, .along = along};
  }
  // The robot's top support carries the mirror and leans when its columns are not equally warm.
  const auto& optics = parameters_.optics;
  Vec3 lean{};
  for (std::size_t k = 0; k < kArms; ++k) {
    const double rise_mm =
        growth_mm(parameters_.delta.upwards[k].front(), parameters_.reference_degc, at.frame.degc);
    lean = lean + (2 * rise_mm / (3 * optics.fold_span_mm / 2)) *
                      cross(Vec3{0, 0, 1}, machine_.carriages[k].outward);
  }
  const Vec3 fold = spot + optics.fold_height_mm * Vec3{0, 0, 1};
  const Vec3 turned = rotation_by(-1.0 * lean) * unit({1, 0, 1});
  // Aligned through the mirror as it stood: back from the cube, turned, out to the head.
  const Vec3 down = unit(aligned + machine_.beam_error_rad[axis]);
  const LightRay back = folded({.from_mm = fold, .along = -1.0 * down}, fold, unit({1, 0, 1}));
  const Vec3 head = fold + (dead_mm - optics.fold_height_mm) * back.along;
  return folded({.from_mm = head, .along = -1.0 * back.along}, fold, turned);
}

PathReading MicroNanoPlant::path(std::size_t axis, const Instant& at) const {
  PathReading reading = path_to(ray(axis, at), face(axis, at));
  const auto& b = parameters_.beams[axis];
  reading.path_mm += growth_mm(b.datum, parameters_.reference_degc, at.frame.degc) +
                     growth_mm(b.device, parameters_.reference_degc, at.frame.degc);
  return reading;
}

CellPlant::Beam MicroNanoPlant::beam(int index, double time_s) const {
  const auto axis = static_cast<std::size_t>(index);
  const Instant& at = instant(time_s);
  const PathReading reading = path(axis, at);
  const double dead_mm = parameters_.interferometers[axis].dead_path_mm;
  const double true_nm = (reading.path_mm - dead_mm) * kNmPerMm;
  return {.frame = at.frame,
          .true_nm = true_nm,
          .disturbed_nm = disturbed(DisturbancePlace::interferometer_nm,
                                    {.time_s = time_s,
                                     .index = index,
                                     .approach = at.servo.front().approach,
                                     .since_move_s = at.servo.front().since_end_s}),
          .hidden_nm = hidden_beam_nm(index, at.frame, time_s, true_nm),
          .lost = reading.tilt_rad > parameters_.optics.tilt_limit_arcsec * kRadPerArcsec};
}

void MicroNanoPlant::before_command() {
  const Instant& at = instant(now_s());
  load_.settle(now_s(), at.wire_mm);
  recent_.forget();
}

// What hangs, and the pan.
double MicroNanoPlant::hidden_force_n(double time_s) const {
  return load_.state(time_s).newton + parameters_.load.pan_n;
}

LoadState MicroNanoPlant::load(TimeNs now) {
  advance_to(now);
  return load_.state(now_s());
}

void MicroNanoPlant::set_load(double newton, TimeNs now) {
  check(newton >= 0 && newton <= parameters_.load.max_n, "load: out of the weights' range");
  advance_to(now);
  before_command();
  load_.set_newton(newton, now_s());
  note("load");
}

void MicroNanoPlant::set_load_jammed(bool jammed, TimeNs now) {
  advance_to(now);
  before_command();
  load_.set_jammed(jammed, now_s());
}

void MicroNanoPlant::set_collimator_fault(int index, CollimatorFault fault, TimeNs now) {
  check(index >= 0 && index < collimator_count(), "autocollimator: no such one");
  advance_to(now);
  collimator_faults_[static_cast<std::size_t>(index)] = fault;
}

}  // namespace driftwise::simulated
