#include "tests/hidden_effects/foreign/plan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace driftwise::foreign {
namespace {

using Eigen::VectorXd;

// Stops collected for one plan; `zero` is the motor position that counts as zero (-1 or 0).
struct Draft {
  int axes;
  int rows;
  double zero;
  Random& random;
  std::vector<Visit> visits;
  int line = 0;

  int measured() const {
    return static_cast<int>(
        std::count_if(visits.begin(), visits.end(), [](const Visit& v) { return v.measured; }));
  }
  Visit& go(const VectorXd& s, double dwell_s) {
    Visit visit;
    visit.s = s.cwiseMax(-1.0).cwiseMin(1.0);
    visit.dwell_s = dwell_s;
    visit.line = line;
    visits.push_back(visit);
    return visits.back();
  }
  void go_zero(double dwell_s) { go(VectorXd::Constant(axes, zero), dwell_s).zero = true; }
  VectorXd anywhere() {
    VectorXd s(axes);
    for (int i = 0; i < axes; ++i) {
      s[i] = random.uniform(-1.0, 1.0);
    }
    return s;
  }
};

std::vector<VectorXd> lattice_places(int axes, int per_axis) {
  std::vector<VectorXd> places;
  const int total = static_cast<int>(std::lround(std::pow(per_axis, axes)));
  for (int k = 0; k < total; ++k) {
    VectorXd s(axes);
    int rest = k;
    bool back = false;
    // Serpentine order: each axis turns where the slower one steps.
    std::vector<int> digits(static_cast<std::size_t>(axes));
    for (int i = 0; i < axes; ++i) {
      digits[i] = rest % per_axis;
      rest /= per_axis;
    }
    for (int i = axes - 1; i >= 0; --i) {
      const int digit = back ? per_axis - 1 - digits[i] : digits[i];
      s[i] = -1.0 + 2.0 * digit / (per_axis - 1);
      back = (digits[i] % 2 == 1) != back;
    }
    places.push_back(s);
  }
  return places;
}

int per_axis_of(int axes, Random& random) {
  switch (axes) {
    case 1:
      return 8 + random.below(14);
    case 2:
      return 5 + random.below(5);
    case 3:
      return 4 + random.below(3);
    case 4:
      return 4;
    default:
      return 3;
  }
}

void lattice(Draft& draft, bool shuffled) {
  std::vector<VectorXd> places = lattice_places(draft.axes, per_axis_of(draft.axes, draft.random));
  const int line_length = static_cast<int>(std::lround(std::sqrt(places.size())));
  const double dwell = draft.random.uniform(1.0, 10.0);
  while (draft.measured() < draft.rows) {
    if (shuffled) {
      for (int k = static_cast<int>(places.size()) - 1; k > 0; --k) {
        std::swap(places[k], places[draft.random.below(k + 1)]);
      }
    }
    draft.go_zero(dwell);
    int count = 0;
    for (const VectorXd& place : places) {
      draft.go(place, dwell);
      if (++count % line_length == 0) {
        ++draft.line;
        draft.go_zero(dwell);
      }
    }
    ++draft.line;
  }
}

// ISO 230-2: targets with an irregular offset, approached from both sides, five cycles per line.
void iso230_2(Draft& draft) {
  const int targets = 5 + draft.random.below(7);
  std::vector<double> offsets;
  for (int k = 0; k < targets; ++k) {
    offsets.push_back(draft.random.uniform(-0.25, 0.25));
  }
  const double step = 1.8 / targets;
  const double dwell = draft.random.uniform(2.0, 6.0);
  while (draft.measured() < draft.rows) {
    for (int axis = 0; axis < draft.axes; ++axis) {
      VectorXd s = draft.anywhere();
      for (int way = 0; way < 2; ++way) {
        s[axis] = way == 0 ? -1.0 : 1.0;
        draft.go(s, dwell).measured = false;  // overrun, so that each target has one side
        for (int k = 0; k < targets; ++k) {
          const int target = way == 0 ? k : targets - 1 - k;
          s[axis] = -0.9 + step * (target + 0.5 + offsets[target]);
          draft.go(s, dwell);
        }
      }
      ++draft.line;
    }
  }
}

// ISO 230-3: a few places again and again through a day of changing heat.
void iso230_3(Draft& draft) {
  std::vector<VectorXd> places;
  for (int k = 0; k < draft.axes + 3; ++k) {
    places.push_back(draft.anywhere());
  }
  const int phase_rows = std::max(20, draft.rows / 4);
  while (draft.measured() < draft.rows) {
    const bool warm = (draft.measured() / phase_rows) % 2 == 1;
    for (const VectorXd& place : places) {
      Visit& visit = draft.go(place, 4.0);
      visit.activity = warm ? 0.8 : 0.0;
    }
    draft.visits.back().pause_s = draft.random.uniform(10.0, 40.0);
    ++draft.line;
  }
}

// ISO 230-6: body diagonals there and back, with a line along each axis.
void iso230_6(Draft& draft) {
  const int steps = 6 + draft.random.below(6);
  while (draft.measured() < draft.rows) {
    VectorXd direction(draft.axes);
    for (int i = 0; i < draft.axes; ++i) {
      direction[i] = draft.random.sign();
    }
    for (int k = 0; k < 2 * steps; ++k) {
      const int at = k < steps ? k : 2 * steps - 1 - k;
      draft.go(direction * (-1.0 + 2.0 * at / (steps - 1)), 3.0);
    }
    ++draft.line;
    const int axis = draft.random.below(draft.axes);
    VectorXd s = draft.anywhere();
    for (int k = 0; k < steps; ++k) {
      s[axis] = -1.0 + 2.0 * k / (steps - 1);
      draft.go(s, 3.0);
    }
    ++draft.line;
  }
}

// ISO 9283: five poses in the cube's diagonal plane (more for many axes), thirty cycles, one order.
void iso9283(Draft& draft) {
  std::vector<VectorXd> poses{VectorXd::Zero(draft.axes)};
  for (int k = 0; k < 4 + std::max(0, draft.axes - 2); ++k) {
    VectorXd s(draft.axes);
    for (int i = 0; i < draft.axes; ++i) {
      s[i] = 0.8 * draft.random.sign() * draft.random.uniform(0.9, 1.0);
    }
    poses.push_back(s);
  }
  while (draft.measured() < draft.rows) {
    for (const VectorXd& pose : poses) {
      draft.go(pose, 3.0);
    }
    ++draft.line;
  }
}

void latin_hypercube(Draft& draft) {
  const int levels = std::max(20, draft.rows / 4);
  while (draft.measured() < draft.rows) {
    std::vector<std::vector<int>> order(static_cast<std::size_t>(draft.axes));
    for (std::vector<int>& column : order) {
      for (int k = 0; k < levels; ++k) {
        column.push_back(k);
      }
      for (int k = levels - 1; k > 0; --k) {
        std::swap(column[k], column[draft.random.below(k + 1)]);
      }
    }
    for (int k = 0; k < levels; ++k) {
      VectorXd s(draft.axes);
      for (int i = 0; i < draft.axes; ++i) {
        s[i] = -1.0 + 2.0 * (order[i][k] + draft.random.uniform(0.0, 1.0)) / levels;
      }
      draft.go(s, 2.0);
      if (k % 25 == 24) {
        ++draft.line;
        draft.go_zero(2.0);
      }
    }
  }
}

// Halton points, as a laboratory takes them for a space-filling plan.
void halton(Draft& draft) {
  static const int kPrimes[] = {2, 3, 5, 7, 11, 13};
  for (int k = 1; draft.measured() < draft.rows; ++k) {
    VectorXd s(draft.axes);
    for (int i = 0; i < draft.axes; ++i) {
      double value = 0.0;
      double share = 1.0;
      for (int rest = k; rest > 0; rest /= kPrimes[i]) {
        share /= kPrimes[i];
        value += share * (rest % kPrimes[i]);
      }
      s[i] = 2.0 * value - 1.0;
    }
    draft.go(s, 2.0);
    draft.line = k / 20;
  }
}

// ISO 230-4: circles both ways at several radii; on one axis the shadow of a circle.
void circles(Draft& draft) {
  const int steps = 18 + draft.random.below(12);
  while (draft.measured() < draft.rows) {
    const int first = draft.random.below(draft.axes);
    const int second = (first + 1 + draft.random.below(std::max(1, draft.axes - 1))) % draft.axes;
    const double radius = draft.random.uniform(0.3, 1.0);
    const double way = draft.random.sign();
    VectorXd s = draft.axes > 2 ? draft.anywhere() : VectorXd(VectorXd::Zero(draft.axes));
    for (int k = 0; k <= steps; ++k) {
      const double angle = way * 2.0 * std::numbers::pi * k / steps;
      s[first] = radius * std::cos(angle);
      if (second != first) {
        s[second] = radius * std::sin(angle);
      }
      draft.go(s, 1.0);
    }
    ++draft.line;
  }
}

void random_walk(Draft& draft) {
  VectorXd s = VectorXd::Constant(draft.axes, draft.zero);
  while (draft.measured() < draft.rows) {
    const int axis = draft.random.below(draft.axes);
    const double step = draft.random.pick(std::vector<double>{0.05, 0.1, 0.2, 0.5});
    double next = s[axis] + step * draft.random.sign();
    if (next < -1.0 || next > 1.0) {
      next = s[axis] - (next - s[axis]);
    }
    s[axis] = next;
    draft.go(s, draft.random.uniform(1.0, 8.0));
    draft.line = draft.measured() / 30;
  }
}

void star_returns(Draft& draft) {
  while (draft.measured() < draft.rows) {
    draft.go_zero(3.0);
    draft.go(draft.anywhere(), 3.0);
    draft.line = draft.measured() / 20;
  }
}

void dwell_series(Draft& draft) {
  static const double kDwells[] = {1.0, 3.0, 10.0, 30.0, 100.0};
  std::vector<VectorXd> places;
  for (int k = 0; k < 4 + 6 * draft.axes; ++k) {
    places.push_back(draft.anywhere());
  }
  while (draft.measured() < draft.rows) {
    const VectorXd& place = draft.random.pick(places);
    VectorXd before = place;
    before[draft.random.below(draft.axes)] += draft.random.sign() * draft.random.uniform(0.1, 0.6);
    draft.go(before, 0.0).measured = false;
    draft.go(place, kDwells[draft.random.below(5)]);
    draft.line = draft.measured() / 15;
  }
}

// Blocks of brisk motion that is not measured, each followed by a set of places; then rest.
void warm_up(Draft& draft) {
  std::vector<VectorXd> places;
  for (int k = 0; k < 6 + 4 * draft.axes; ++k) {
    places.push_back(draft.anywhere());
  }
  for (int block = 0; draft.measured() < draft.rows; ++block) {
    if (block % 4 < 2) {
      for (int k = 0; k < 40; ++k) {
        draft.go(VectorXd::Constant(draft.axes, k % 2 == 0 ? 0.9 : -0.9), 0.0).measured = false;
      }
    }
    for (const VectorXd& place : places) {
      draft.go(place, 2.0).activity = block % 4 < 2 ? 0.9 : 0.1;
    }
    draft.visits.back().pause_s = block % 4 < 2 ? 5.0 : 200.0;
    ++draft.line;
  }
}

void shuttle(Draft& draft) {
  const int steps = 10 + draft.random.below(20);
  while (draft.measured() < draft.rows) {
    const int axis = draft.line % draft.axes;
    VectorXd s = draft.anywhere();
    for (int k = 0; k < 2 * steps; ++k) {
      const int at = k < steps ? k : 2 * steps - k;
      s[axis] = -1.0 + 2.0 * at / steps;
      draft.go(s, 1.0);
    }
    ++draft.line;
  }
}

void few_places(Draft& draft) {
  std::vector<VectorXd> places;
  for (int k = 0; k < 2 + 3 * draft.axes; ++k) {
    places.push_back(draft.anywhere());
  }
  while (draft.measured() < draft.rows) {
    draft.go(draft.random.pick(places), 3.0);
    draft.line = draft.measured() / 25;
  }
}

// By hand: round numbers, uneven pauses, a coffee break, places taken again when in doubt.
void by_hand(Draft& draft) {
  while (draft.measured() < draft.rows) {
    VectorXd s = draft.anywhere();
    for (int i = 0; i < draft.axes; ++i) {
      s[i] = std::round(s[i] * 5.0) / 5.0;
    }
    Visit& visit = draft.go(s, draft.random.uniform(3.0, 30.0));
    visit.pause_s = draft.random.log_uniform(1.0, 30.0);
    if (draft.random.chance(0.01)) {
      visit.pause_s += draft.random.uniform(600.0, 2400.0);
      ++draft.line;
    }
    if (draft.random.chance(0.1)) {
      draft.go(s, 5.0);
    }
  }
}

void spiral(Draft& draft) {
  const int steps = draft.rows / 3;
  while (draft.measured() < draft.rows) {
    const double phase = draft.random.uniform(0.0, 6.28);
    for (int k = 0; k < steps; ++k) {
      const double part = static_cast<double>(k) / steps;
      VectorXd s(draft.axes);
      for (int i = 0; i < draft.axes; ++i) {
        s[i] = (0.1 + 0.9 * part) * std::cos(phase + (7.0 + 2.3 * i) * 6.28 * part + 1.1 * i);
      }
      draft.go(s, 1.0);
      draft.line = draft.measured() / 30;
    }
  }
}

void chebyshev(Draft& draft) {
  const int nodes = 5 + draft.random.below(5);
  while (draft.measured() < draft.rows) {
    VectorXd s(draft.axes);
    for (int i = 0; i < draft.axes; ++i) {
      s[i] = std::cos(std::numbers::pi * (draft.random.below(nodes) + 0.5) / nodes);
    }
    draft.go(s, 2.0);
    draft.line = draft.measured() / 24;
  }
}

struct Kind {
  int degree;
  void (*draw)(Draft&);
};

const std::map<std::string, Kind>& kinds() {
  static const std::map<std::string, Kind> table{
      {"lattice", {3, [](Draft& draft) { lattice(draft, false); }}},
      {"lattice_askew", {3, [](Draft& draft) { lattice(draft, false); }}},
      {"lattice_random_order", {3, [](Draft& draft) { lattice(draft, true); }}},
      {"iso230_2", {2, iso230_2}},
      {"iso230_3", {1, iso230_3}},
      {"iso230_6", {2, iso230_6}},
      {"iso9283", {1, iso9283}},
      {"latin_hypercube", {3, latin_hypercube}},
      {"halton", {3, halton}},
      {"circles", {2, circles}},
      {"random_walk", {2, random_walk}},
      {"star_returns", {3, star_returns}},
      {"dwell_series", {2, dwell_series}},
      {"warm_up", {2, warm_up}},
      {"shuttle", {2, shuttle}},
      {"few_places", {1, few_places}},
      {"by_hand", {2, by_hand}},
      {"spiral", {2, spiral}},
      {"chebyshev", {3, chebyshev}}};
  return table;
}

}  // namespace

const std::vector<std::string>& open_plans() {
  static const std::vector<std::string> open{
      "lattice",     "lattice_askew", "lattice_random_order", "iso230_2", "iso230_3",
      "iso230_6",    "iso9283",       "latin_hypercube",      "halton",   "circles",
      "random_walk", "star_returns",  "dwell_series",         "warm_up",  "shuttle",
      "few_places",  "by_hand"};
  return open;
}

const std::vector<std::string>& reserved_plans() {
  static const std::vector<std::string> reserved{"spiral", "chebyshev"};
  return reserved;
}

int plan_degree(const std::string& kind) { return kinds().at(kind).degree; }

Plan make_plan(const std::string& kind, int axes, int rows, double zero, Random& random) {
  Draft draft{axes, rows, zero, random, {}, 0};
  kinds().at(kind).draw(draft);
  Plan plan;
  plan.kind = kind;
  plan.degree = plan_degree(kind);
  // Cut to the wanted length: a whole lattice may overshoot it, up to twice is kept.
  int measured = 0;
  for (const Visit& visit : draft.visits) {
    plan.visits.push_back(visit);
    measured += visit.measured ? 1 : 0;
    if (measured >= 2 * rows) {
      break;
    }
  }
  return plan;
}

}  // namespace driftwise::foreign
