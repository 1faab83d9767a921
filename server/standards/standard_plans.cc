#include "server/standards/standard_plans.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/core/reasons.h"

namespace driftwise::standards {
namespace {

constexpr int kMostRows = 1000000;

tl::unexpected<Error> bad_plan(const std::string& sentence) {
  return fail(ErrorCode::invalid_argument, reasons::kBadPlan, sentence);
}

// Trajectories are read by people too: whole nanometres.
double to_whole_nm(double mm) { return std::round(mm * 1e6) / 1e6; }

double uniform01(std::uint32_t& state) {  // xorshift32 (Marsaglia 2003): the same on every machine
  state ^= state << 13;
  state ^= state >> 17;
  state ^= state << 5;
  return state / 4294967296.0;
}

class Writer {
 public:
  Writer(std::vector<Channel> axes, const std::vector<Held>& held) : held_(held) {
    trajectory_.coordinates = std::move(axes);
    for (const auto& other : held) trajectory_.coordinates.push_back(other.channel);
    // As the robot's motor coordinates are ordered.
    order_.resize(trajectory_.coordinates.size());
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = i;
    std::ranges::sort(order_, {}, [&](std::size_t i) { return trajectory_.coordinates[i].symbol; });
    std::ranges::sort(trajectory_.coordinates, {}, &Channel::symbol);
  }

  void next_line() { ++line_; }
  void go_to(std::vector<double> axes_mm, std::optional<double> dwell_s = {}) {
    for (const auto& other : held_) axes_mm.push_back(other.at_mm);
    TrajectoryPoint point;
    for (const std::size_t i : order_) point.target.push_back(to_whole_nm(axes_mm[i]));
    point.line = line_;
    point.dwell_s = dwell_s;
    trajectory_.points.push_back(std::move(point));
  }
  void go_to_zero() {
    TrajectoryPoint point;
    point.target.assign(trajectory_.coordinates.size(), 0);
    point.line = line_;
    point.zero = true;
    trajectory_.points.push_back(std::move(point));
  }
  Trajectory take() { return std::move(trajectory_); }

 private:
  const std::vector<Held>& held_;
  Trajectory trajectory_;
  std::vector<std::size_t> order_;
  std::int64_t line_ = 0;
};

// Between the outermost positions each lies up to `scatter` of a step aside, the outermost inwards
// only: the travel is covered and nothing is visited beyond it.
std::vector<double> scattered_positions(const Iso2302Plan& plan) {
  const double step_mm = (plan.to_mm - plan.from_mm) / (plan.positions - 1);
  std::uint32_t state = plan.seed * 2654435761U + 1U;  // never 0
  if (state == 0) state = 1;
  std::vector<double> out;
  for (int i = 0; i < plan.positions; ++i) {
    const double aside = (2 * uniform01(state) - 1) * plan.scatter * step_mm;
    const double at_mm = plan.from_mm + i * step_mm + aside;
    out.push_back(to_whole_nm(std::clamp(at_mm, plan.from_mm, plan.to_mm)));
  }
  return out;
}

}  // namespace

Result<Trajectory> iso230_2_plan(const Iso2302Plan& plan) {
  if (!(plan.from_mm < plan.to_mm)) return bad_plan("expected the first position below the last");
  if (plan.positions < 5 || plan.positions > 10000)
    return bad_plan("found " + std::to_string(plan.positions) +
                    " positions, expected 5 or more (and 5 or more per metre)");
  if (plan.approaches < 5 || plan.approaches > 1000)
    return bad_plan("found " + std::to_string(plan.approaches) +
                    " approaches from each side, expected 5 or more");
  if (!(plan.scatter >= 0 && plan.scatter < 0.5))
    return bad_plan("expected a scatter from 0 up to, not including, 0.5 of the step");
  if (!(plan.overrun_mm >= 0)) return bad_plan("expected an overrun of 0 mm (by itself) or more");
  const double step_mm = (plan.to_mm - plan.from_mm) / (plan.positions - 1);
  const double overrun_mm = plan.overrun_mm > 0 ? plan.overrun_mm : step_mm / 4;
  const auto positions = scattered_positions(plan);
  Writer writer({plan.axis}, plan.held);
  writer.go_to_zero();
  // The overrun leads its pass: a run may return to zero between two lines, in no row.
  for (int cycle = 0; cycle < plan.approaches; ++cycle) {
    writer.next_line();
    writer.go_to({positions.front() - overrun_mm});
    for (const double at_mm : positions) writer.go_to({at_mm});
    writer.next_line();
    writer.go_to({positions.back() + overrun_mm});
    for (auto at = positions.rbegin(); at != positions.rend(); ++at) writer.go_to({*at});
  }
  writer.next_line();
  writer.go_to_zero();
  return writer.take();
}

Result<Trajectory> iso230_3_plan(const Iso2303Plan& plan) {
  if (plan.at_mm.empty()) return bad_plan("expected at least one position");
  if (!(plan.hours > 0) || !(plan.every_s > 0) || !(plan.overrun_mm > 0))
    return bad_plan("expected a duration, a round and an overrun above 0");
  const double rounds = std::ceil(plan.hours * 3600 / plan.every_s) + 1;
  if (rounds * static_cast<double>(plan.at_mm.size() + 1) > kMostRows)
    return bad_plan("expected fewer than a million rows: a longer round, or fewer hours");
  auto positions = plan.at_mm;
  std::ranges::sort(positions);
  const bool rests = positions.size() == 1;
  Writer writer({plan.axis}, plan.held);
  writer.go_to_zero();
  for (int round = 0; round < static_cast<int>(rounds); ++round) {
    if (round == 0 || !rests) writer.next_line();  // an axis at rest does not return to zero
    if (!rests) writer.go_to({positions.front() - plan.overrun_mm}, plan.every_s);
    for (const double at_mm : positions)
      writer.go_to({at_mm}, rests ? std::optional(plan.every_s) : std::nullopt);
  }
  return writer.take();
}

Result<Trajectory> iso9283_plan(const Iso9283Plan& plan) {
  const std::size_t n = plan.axes.size();
  if (n < 1 || n > 3 || plan.centre_mm.size() != n)
    return bad_plan("found " + std::to_string(n) + " axes and a centre of " +
                    std::to_string(plan.centre_mm.size()) +
                    " numbers, expected one to three and as many");
  if (!(plan.edge_mm > 0)) return bad_plan("expected an edge of the cube above 0 mm");
  if (plan.cycles < 2 || plan.cycles > 100000)
    return bad_plan("found " + std::to_string(plan.cycles) + " cycles, expected 2 or more");
  // In edges from the centre: a tenth of the diagonal from a corner is 0.4 along each axis.
  constexpr std::array<std::array<double, 3>, 5> kCube = {
      {{0, 0, 0}, {0.4, 0.4, 0.4}, {-0.4, 0.4, 0.4}, {-0.4, -0.4, -0.4}, {0.4, -0.4, -0.4}}};
  constexpr std::array<double, 5> kLine = {0, 0.4, 0.2, -0.2, -0.4};
  Writer writer(plan.axes, plan.held);
  writer.go_to_zero();
  const auto pose = [&](std::size_t p) {
    std::vector<double> at_mm;
    for (std::size_t i = 0; i < n; ++i)
      at_mm.push_back(plan.centre_mm[i] + plan.edge_mm * (n == 1 ? kLine[p] : kCube[p][i]));
    return at_mm;
  };
  // One line: a return to zero between cycles would be where P1 comes from.
  writer.next_line();
  writer.go_to(pose(4));  // so that the first P1 is approached as all others
  for (int cycle = 0; cycle < plan.cycles; ++cycle)
    for (std::size_t p = 0; p < kCube.size(); ++p) writer.go_to(pose(p));
  writer.next_line();
  writer.go_to_zero();
  return writer.take();
}

}  // namespace driftwise::standards
