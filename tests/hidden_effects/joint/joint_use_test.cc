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
#include <cstdlib>
#include <map>
#include <numeric>
#include <optional>
#include <random>

#include "server/calibration/fit.h"
#include "server/plans/joint_target.h"
#include "server/plans/plan_check.h"
#include "tests/hidden_effects/joint/two_robot_models.h"
#include "tests/hidden_effects/joint/two_robot_plant.h"
#include "tests/statistics/coverage_count.h"

namespace driftwise::plans {
namespace {

using compensation::Variable;
using joint_plant::Pose;
using joint_use::cell_of_both;
using joint_use::Knowledge;
using joint_use::Machine;
using joint_use::micro_nano_model;
using joint_use::models_of;
using joint_use::plan_of;

constexpr int kPlants = 10, kPoses = 200;

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

// Both robots under a plan, from their common zero on: motor coordinates there, and every
// temperature.
class Use {
 public:
  Use(Machine& plant, const ServingPlan& plan, const ModelsById& models, std::uint64_t seed)
      : plant_(plant), room_(seed + 5, 20.0, 21.2, 4), random_(seed + 6) {
    const CellDescription cell = cell_of_both();
    const auto check = check_plan(plan, models, {}, cell);
    if (const auto good = check.refusal(); !good) throw std::runtime_error(good.error().message);
    auto builder = JointBuilder::create(plan, PlanId{1}, models, cell);
    if (!builder) throw std::runtime_error(builder.error().message);
    builder_.emplace(std::move(*builder));
    room_.advance(600);
    const auto mq = joint_plant::MinAngle::read_back(plant.m.motors_at(0, 0, 0, room_));
    const auto aq = plant.a.motors_at(0, 0, 0, room_);
    piece_zero = plant.m.pose(mq, room_);
    tool_zero = plant.a.pose(aq, room_);
    std::vector<ChannelValue> zero = {
        {"t05_degC", room_.t05()}, {"t08_degC", room_.t08()}, {"t09_degC", room_.t09()}};
    for (std::size_t i = 0; i < 3; ++i) {
      zero.push_back({"ma.q" + std::to_string(i + 1) + "_mm", mq[i]});
      zero.push_back({"mn.q" + std::to_string(i + 1) + "_mm", aq[i]});
    }
    const auto trouble = builder_->anchor(zero, [](ModelId) { return false; });
    if (!trouble.empty()) throw std::runtime_error(trouble.front());
  }

  // A minute later, another random joint pose: what the plan answers, and where both really are.
  struct Visit {
    Pose tool, piece;                            // wanted
    JointTarget target;                          // mn first, then ma
    Pose real_tool, real_piece;                  // absolute
    std::array<compensation::Budget, 6> budget;  // of each robot's own model at its own pose
    std::array<double, 6> added_nm{};            // what the steps bring to that
  };
  Visit next() {
    room_.advance(60);
    const CellTime now{static_cast<std::int64_t>(room_.now_s() * 1e9)};
    const ChannelValue seen[] = {
        {"t05_degC", room_.t05()}, {"t08_degC", room_.t08()}, {"t09_degC", room_.t09()}};
    builder_->observe(seen, now);
    const auto within = [this](double low, double high) {
      return std::uniform_real_distribution<>(low, high)(random_);
    };
    Visit visit;
    visit.tool = {within(0, 2.5), within(0, 2.5), within(0, 2.5), 0, 0, 0};
    visit.piece = {0, 0, within(-2.5, 2.5), within(-250, 250), within(-250, 250), 0};
    const auto snapshot = builder_->build(now);
    JointRequest request;
    request.now = now;
    request.set(0, Variable::x, visit.tool.x);
    request.set(0, Variable::y, visit.tool.y);
    request.set(0, Variable::z, visit.tool.z);
    request.set(1, Variable::z, visit.piece.z);
    request.set(1, Variable::rx, visit.piece.rx);
    request.set(1, Variable::ry, visit.piece.ry);
    visit.target = compute_joint_target(snapshot, request);
    if (visit.target.refusal != compensation::Refusal::none)
      throw std::runtime_error(joint_refusal_error(snapshot, visit.target).message);
    for (std::size_t i = 0; i < 6; ++i) {
      const auto& robot = snapshot.robots[i / 3];
      compensation::TargetRequest own;
      own.value = visit.target.robot[i / 3].pose;
      own.given = robot.fine.needed;
      own.now = now;
      visit.budget[i] = compensation::compute_budget(robot.fine, own, i % 3);
      visit.added_nm[i] = std::sqrt(
          std::max(0.0, std::pow(visit.target.u_nm[i], 2) - std::pow(visit.budget[i].u_nm, 2)));
    }
    const auto& q = visit.target.q_mm;
    visit.real_tool = plant_.a.pose({q[0], q[1], q[2]}, room_);
    visit.real_piece = plant_.m.pose({q[3], q[4], q[5]}, room_);
    return visit;
  }
  const joint_plant::Room& room() const { return room_; }

  Pose piece_zero, tool_zero;

 private:
  Machine& plant_;
  joint_plant::Room room_;
  std::mt19937_64 random_;
  std::optional<JointBuilder> builder_;
};

// The four ways: none, translations, tilts, both.
std::array<Figures, 4> figures_of(std::uint64_t seed) {
  Machine plant(seed);
  const ModelsById models = models_of(plant, seed, Knowledge::study);
  std::array<Figures, 4> out;
  for (int way = 0; way < 4; ++way) {
    Use use(plant, plan_of((way & 1) != 0, (way & 2) != 0), models, seed);
    double contact = 0, sideways = 0, angle = 0;
    for (int k = 0; k < kPoses; ++k) {
      const auto visit = use.next();
      const auto at = contact_of(visit.real_tool, visit.real_piece, visit.tool, visit.piece,
                                 use.tool_zero, use.piece_zero);
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

// Of the joint targets' motor coordinates, mn q1 to q3 and ma q1 to q3: error at the truth against
// the stated expanded uncertainty.
struct Coverage {
  std::array<statistics::CoverageCount, 6> count;
  statistics::CoverageCount pooled;                           // over the six
  std::array<double, 6> error_nm{}, stated_nm{}, added_nm{};  // sums of squares
  std::map<std::string, std::array<double, 6>> lines_nm;      // likewise, by name
  int targets = 0;

  void add_campaign(std::uint64_t seed, Knowledge knowledge) {
    Machine plant(seed);
    const ModelsById models = models_of(plant, seed, knowledge);
    // With tilts in the sideways motion the steps wait for one another, in a circle.
    Use use(plant, plan_of(true, true), models, seed);
    std::array<std::int64_t, 6> hits{};
    for (int k = 0; k < kPoses; ++k) {
      const auto visit = use.next();
      const auto needed = needed_for(plant, use, visit);
      for (std::size_t i = 0; i < 6; ++i) {
        const double error = 1e6 * (visit.target.q_mm[i] - needed[i]);
        hits[i] += std::abs(error) <= visit.target.expanded_nm(i) ? 1 : 0;
        error_nm[i] += error * error;
        stated_nm[i] += visit.target.u_nm[i] * visit.target.u_nm[i];
        added_nm[i] += visit.added_nm[i] * visit.added_nm[i];
        for (std::size_t l = 0; l < visit.budget[i].lines; ++l) {
          const auto& line = visit.budget[i].line[l];
          lines_nm[std::string(compensation::to_string(line.source))][i] += line.u_nm * line.u_nm;
        }
      }
      ++targets;
    }
    for (std::size_t i = 0; i < 6; ++i) count[i].add_campaign(hits[i], kPoses);
    pooled.add_campaign(std::accumulate(hits.begin(), hits.end(), std::int64_t{0}), 6 * kPoses);
  }

  // Motor coordinates at which the tool would have followed the work-piece's sideways motion, and
  // the work-piece the tool's tilt, as they really are.
  static std::array<double, 6> needed_for(const Machine& plant, const Use& use,
                                          const Use::Visit& visit) {
    const auto q =
        plant.a.motors_at(use.tool_zero.x + visit.tool.x + visit.real_piece.x - use.piece_zero.x,
                          use.tool_zero.y + visit.tool.y + visit.real_piece.y - use.piece_zero.y,
                          use.tool_zero.z + visit.tool.z, use.room());
    const auto p = plant.m.motors_at(
        use.piece_zero.rx + visit.piece.rx + visit.real_tool.rx - use.tool_zero.rx,
        use.piece_zero.ry + visit.piece.ry + visit.real_tool.ry - use.tool_zero.ry,
        use.piece_zero.z + visit.piece.z, use.room());
    return {q[0], q[1], q[2], p[0], p[1], p[2]};
  }

  void print() const {
    std::printf("%d campaigns x %d joint poses\n", static_cast<int>(count[0].campaigns()), kPoses);
    std::printf("%-8s %10s %22s %14s %12s\n", "motor", "within U", "95 % (by campaign)",
                "rms error nm", "stated u nm");
    constexpr const char* kMotors[] = {"mn.q1", "mn.q2", "mn.q3", "ma.q1", "ma.q2", "ma.q3"};
    for (std::size_t i = 0; i < 6; ++i) {
      const auto interval = count[i].clustered();
      std::printf("%-8s %8.1f %% %12.1f to %.1f %% %14.1f %12.1f\n", kMotors[i],
                  100 * count[i].rate(), 100 * interval.low, 100 * interval.high,
                  std::sqrt(error_nm[i] / targets), std::sqrt(stated_nm[i] / targets));
    }
    std::printf("%-8s %8.1f %% %12.1f to %.1f %%\n", "all", 100 * pooled.rate(),
                100 * pooled.clustered().low, 100 * pooled.clustered().high);
    std::printf("budget, rms over the targets, nm:\n");
    for (std::size_t i = 0; i < 6; ++i) {
      std::printf("  %s:", kMotors[i]);
      for (const auto& [name, squares] : lines_nm)
        if (squares[i] > 0) std::printf(" %s %.1f", name.c_str(), std::sqrt(squares[i] / targets));
      std::printf(" predicted motion %.1f\n", std::sqrt(added_nm[i] / targets));
    }
  }
};

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

// First seed of a count: DRIFTWISE_JOINT_SEED, else the one that the daily test runs with.
std::uint64_t first_seed(std::uint64_t otherwise) {
  const char* seed = std::getenv("DRIFTWISE_JOINT_SEED");
  return seed ? static_cast<std::uint64_t>(std::atoll(seed)) : otherwise;
}

TEST(JointUse, GainsByTranslationsInPlaceAndByTiltsInAngleOverTenPlants) {
  const auto first = first_seed(7000);
  constexpr const char* kWays[] = {"none", "translations", "tilts", "both"};
  std::array<std::vector<double>, 4> contact, sideways, angle;
  for (int plant = 0; plant < kPlants; ++plant) {
    const auto figures = figures_of(first + 17 * static_cast<std::uint64_t>(plant));
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

// Campaigns: DRIFTWISE_JOINT_CAMPAIGNS, else 8; their first seed: DRIFTWISE_JOINT_SEED;
// DRIFTWISE_JOINT_TERMS=complete leaves the study's terms out. The count
// of 100 stands in docs/plans.md. The study's terms are counted, not judged: what they lack no fit
// of them can state.
TEST(JointUse, StatesUncertaintiesThatHoldTheErrors) {
  const char* asked = std::getenv("DRIFTWISE_JOINT_CAMPAIGNS");
  const int campaigns = asked ? std::atoi(asked) : 8;
  const auto first = first_seed(90'000);
  const char* terms = std::getenv("DRIFTWISE_JOINT_TERMS");
  for (const auto knowledge : {Knowledge::study, Knowledge::complete}) {
    if (terms && knowledge == Knowledge::study && std::string_view(terms) == "complete") continue;
    Coverage coverage;
    for (int k = 0; k < campaigns; ++k)
      coverage.add_campaign(first + 29 * static_cast<std::uint64_t>(k), knowledge);
    std::printf("%s terms: ", knowledge == Knowledge::study ? "the study's" : "complete");
    coverage.print();
    if (knowledge == Knowledge::study) continue;
    // A campaign's targets share most of their error, so that a few campaigns say little: what they
    // may not say is that fewer than the wanted are covered.
    for (const auto& one : coverage.count)
      EXPECT_GT(one.clustered().high, 0.92) << "of them " << 100 * one.rate() << " %";
  }
}

double value_of(const effects::Term& term, const Pose& at) {
  double value = 1;
  for (const auto& factor : term.factors) {
    const auto& power = std::get<effects::Power>(factor);
    const double coordinate = power.symbol == "mn.x" ? at.x : power.symbol == "mn.y" ? at.y : at.z;
    value *= std::pow(coordinate, power.exponent);
  }
  return value;
}

// Predicted tilts, 20 terms offered of which 9 act, from the zero to a pose: square of the error
// over the square that the coefficients' covariance states. What a selection adds to the error by
// the terms that it takes by chance and leaves out for their smallness is in no line of a budget
// (docs/uncertainty.md).
double square_over_stated(calibration::Select select) {
  double squares = 0, stated = 0;
  for (std::uint64_t k = 0; k < 40; ++k) {
    Machine plant(95'000 + 29 * k);
    joint_plant::Room room(95'004 + 29 * k, 19.8, 20.2, 1.2);
    const auto model = micro_nano_model(plant, room, true, Knowledge::complete, select);
    const auto tilt_at = [&](const Pose& at) {
      return plant.a.pose(plant.a.motors_at(at.x, at.y, at.z, room), room).rx;
    };
    const auto& rx = model.outputs.front();
    std::mt19937_64 random(k);
    std::uniform_real_distribution<> within(0, 2.5);
    for (int pose = 0; pose < 50; ++pose) {
      const Pose at{within(random), within(random), within(random)}, zero{};
      Eigen::VectorXd change(rx.coefficients.size());
      for (Eigen::Index t = 0; t < change.size(); ++t) {
        const auto& term = rx.terms[static_cast<std::size_t>(t)];
        change[t] = value_of(term, at) - value_of(term, zero);
      }
      squares += std::pow(change.dot(rx.coefficients) - (tilt_at(at) - tilt_at(zero)), 2);
      stated += change.dot(rx.covariance * change);
    }
  }
  return squares / stated;
}

TEST(JointUse, StatesTheScatterOfCoefficientsAsFarAsNoTermsWereSelected) {
  const double all = square_over_stated(calibration::Select::all),
               selected = square_over_stated(calibration::Select::stepwise);
  std::printf("error squared over stated: all terms %.2f, selected %.2f\n", all, selected);
  EXPECT_GT(all, 0.7);
  EXPECT_LT(all, 1.4);
  EXPECT_GT(selected, all) << "a selection costs something, and nothing states it";
}

}  // namespace
}  // namespace driftwise::plans
