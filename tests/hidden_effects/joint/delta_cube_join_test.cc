// Three sessions on the Delta Cube 2's plant, joined, against a session that measures all six
// coordinates at once, both at the plant's truth; and wrong joins of the same data.

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "drivers/simulated/plant/file/make_plant.h"
#include "server/core/units.h"
#include "server/correction/dataset_join.h"

namespace driftwise::correction {
namespace {

using simulated::DeltaCubePlant;
using simulated::TimeNs;

constexpr TimeNs kStart = 1'600'000'000'000'000'000;
constexpr double kOpened_s = 1800, kStabilised_s = 9 * 3600;

// What the cell file declares of the spots.
Stage declared() {
  Stage stage;
  stage.cosine = true;
  stage.beams[0] = {.at_zero_mm = {-15, 0, -3}, .per_pose = {0, -1, -1}};
  stage.beams[1] = {.at_zero_mm = {4, -15, -2}, .per_pose = {-1, 0, -1}};
  stage.beams[2] = {.at_zero_mm = {2, -1, -15}, .per_pose = {-1, -1, 0}};
  return stage;
}

struct Session {
  JoinPart part;
  std::map<std::string, std::vector<double>> truth;  // mm, arcsec, since its first return
};

class Campaign {
 public:
  // rest_s: at each place before it is read.
  explicit Campaign(std::uint64_t seed, double rest_s = 10)
      : rest_s_(rest_s),
        plant_(simulated::make_delta_cube_plant(
            DRIFTWISE_SOURCE_DIR "/deploy/cells/delta-cube-2/plant.toml",
            {.seed = seed,
             .overrides = {"plant.step_s=0.5", "interferometer.disturbances_per_hour=0"},
             .epoch_ns = kStart})) {
    for (int i = 0; i < 3; ++i) plant_->start_reference(i, now());
    pass(20);
  }

  // 5 x 5 x 5 places, a return to zero before each line and at the end.
  Session session(const std::string& name, const std::vector<std::string>& measures) {
    Session out;
    auto& data = out.part.data;
    out.part.name = name;
    out.part.tool = "cube";
    out.part.stage = declared();
    for (const char* q : {"q1", "q2", "q3"}) data.columns.push_back({{q, "mm"}, {}});
    for (const auto& symbol : measures) {
      if (symbol.size() == 1) data.columns.push_back({{symbol + "_path", "mm"}, {}});
      data.columns.push_back({{symbol, symbol.size() == 1 ? "mm" : "arcsec"}, {}});
    }
    for (int i = 0; i < 3; ++i) plant_->zero_length(i, now());
    for (double a = -1.8; a < 2; a += 0.9)
      for (double b = -1.8; b < 2; b += 0.9) {
        visit({0, 0, 0}, true, measures, out);
        for (double c = -1.8; c < 2; c += 0.9) visit({a, b, c}, false, measures, out);
      }
    visit({0, 0, 0}, true, measures, out);
    // Tilts count from the first return, as from a datum.
    for (auto& column : data.columns)
      if (column.channel.unit == "arcsec")
        for (std::size_t row = data.rows; row-- > 0;) column.values[row] -= column.values[0];
    correct(measures, data);
    for (auto& [symbol, values] : out.truth)
      for (std::size_t row = values.size(); row-- > 0;) values[row] -= values[0];
    return out;
  }

  void carry_instruments() {
    ASSERT_TRUE(plant_->open_box(kOpened_s, now()));
    pass(kOpened_s + kStabilised_s);
  }

 private:
  TimeNs now() const { return kStart + static_cast<TimeNs>(std::llround(1e9 * time_s_)); }
  void pass(double seconds) {
    time_s_ += seconds;
    plant_->advance_to(now());
  }

  void visit(const std::array<double, 3>& q_mm, bool zero, const std::vector<std::string>& measures,
             Session& out) {
    for (int i = 0; i < 3; ++i) plant_->start_move(i, q_mm[static_cast<std::size_t>(i)], now());
    pass(rest_s_);
    auto& data = out.part.data;
    std::size_t at = 0;
    std::array<double, 3> read_mm{};
    for (int i = 0; i < 3; ++i) read_mm[static_cast<std::size_t>(i)] = plant_->axis(i, now()).q_mm;
    for (const double one : read_mm) data.columns[at++].values.push_back(one);
    const auto true_pose = plant_->pose(time_s_);
    for (const auto& symbol : measures) {
      const int axis = symbol.back() - 'x';
      if (symbol.size() == 1) {
        double sum_nm = 0;
        for (int reading = 0; reading < 4; ++reading) {
          sum_nm += plant_->measure_length(axis, now(), 2048).mean_nm;
          time_s_ += 0.5;
        }
        data.columns[at++].values.push_back(1e-6 * sum_nm / 4);
        data.columns[at++].values.push_back(0);
      } else {
        // ry by the autocollimator along x unless rx is measured too and rz is not.
        const bool along_z =
            axis == 0 || (axis == 1 && std::ranges::find(measures, "rz") == measures.end());
        double sum_arcsec = 0;
        for (int reading = 0; reading < 4; ++reading) {
          time_s_ += 0.1;
          const auto one = plant_->measure_angle(along_z ? 1 : 0, 0.1, now());
          sum_arcsec += (axis == 0 || (axis == 1 && !along_z)) ? one.y_arcsec : one.z_arcsec;
        }
        data.columns[at++].values.push_back(sum_arcsec / 4);
      }
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string letter(1, static_cast<char>('x' + i));
      out.truth[letter].push_back(1e-6 * true_pose.position_nm[i]);
      out.truth["r" + letter].push_back(true_pose.rotation_arcsec[i]);
    }
    data.time_s.push_back(time_s_);
    data.zero.push_back(zero ? 1 : 0);
    ++data.rows;
  }

  // As the cell's own stage does: with the angles that this session measures.
  static void correct(const std::vector<std::string>& measures, Dataset& data) {
    const auto values = [&](const std::string& symbol, std::size_t row) {
      const auto* column = data.find(symbol);
      return column == nullptr ? 0.0 : column->values[row];
    };
    for (std::size_t row = 0; row < data.rows; ++row) {
      const Tilt tilt{values("rx", row), values("ry", row), values("rz", row)};
      const auto pose = pose_from_paths(
          {values("x_path", row), values("y_path", row), values("z_path", row)}, tilt, declared());
      for (const auto& symbol : measures)
        if (symbol.size() == 1)
          for (auto& column : data.columns)
            if (column.channel.symbol == symbol)
              column.values[row] = pose[static_cast<std::size_t>(symbol[0] - 'x')];
    }
  }

  double rest_s_;
  std::unique_ptr<DeltaCubePlant> plant_;
  double time_s_ = 0;
};

struct Sessions {
  Session first, second, third, all;
};
Sessions three_sessions(Campaign& campaign) {
  Sessions out;
  out.first = campaign.session("first", {"x", "ry", "rz"});
  campaign.carry_instruments();
  out.second = campaign.session("second", {"y", "rx", "ry"});
  campaign.carry_instruments();
  out.third = campaign.session("third", {"z"});
  return out;
}
const Sessions& sessions() {
  static const Sessions made = [] {
    Campaign campaign(5);
    Sessions out = three_sessions(campaign);
    campaign.carry_instruments();
    out.all = campaign.session("all", {"x", "y", "z", "rx", "ry", "rz"});
    return out;
  }();
  return made;
}

// Zeros at the mean of the returns; nm or arcsec.
double rms_error(const Dataset& data, const std::string& symbol, const std::vector<double>& truth) {
  const auto& measured = data.find(symbol)->values;
  const double factor = symbol.size() == 1 ? 1e6 : 1;
  std::vector<double> errors;
  double at_returns = 0, returns = 0;
  for (std::size_t row = 0; row < data.rows; ++row) {
    errors.push_back(factor * (measured[row] - truth[row]));
    if (data.zero[row] == 0) continue;
    at_returns += errors.back();
    returns += 1;
  }
  double squares = 0;
  for (const double error : errors) squares += std::pow(error - at_returns / returns, 2);
  return std::sqrt(squares / static_cast<double>(errors.size()));
}

double rms_error(const Dataset& data, const std::string& symbol, const Session& where) {
  return rms_error(data, symbol, where.truth.at(symbol));
}

// Pose of the robot at the mean of the three sessions' motor coordinates, which a joined row has:
// the mean of the three true poses, for they are 100 nm apart at most.
std::vector<double> mean_truth(const Sessions& made, const std::string& symbol) {
  std::vector<double> mean = made.first.truth.at(symbol);
  for (std::size_t row = 0; row < mean.size(); ++row)
    mean[row] =
        (mean[row] + made.second.truth.at(symbol)[row] + made.third.truth.at(symbol)[row]) / 3;
  return mean;
}

// Plants: DRIFTWISE_JOIN_PLANTS, else 3; first seed: DRIFTWISE_JOIN_SEED, else 40; rest at a place:
// DRIFTWISE_JOIN_REST_S, else 50, so that a session lasts as long as on the wire. A plant has one
// error of each kind, so that ten say whether the size that is stated is the size that there is.
TEST(DeltaCubeSessions, ErrByWhatTheyStateOverSeveralPlants) {
  const auto asked = [](const char* name, int otherwise) {
    const char* value = std::getenv(name);
    return value ? std::atoi(value) : otherwise;
  };
  const int plants = asked("DRIFTWISE_JOIN_PLANTS", 3), first = asked("DRIFTWISE_JOIN_SEED", 40),
            rest_s = asked("DRIFTWISE_JOIN_REST_S", 50);
  struct Sums {
    double error2 = 0, u2 = 0, at_once2 = 0, worst = 0;
    int within = 0;      // plants whose rms error is at most 2 u
    int as_at_once = 0;  // ... at most that of six coordinates at once and 2 u
  };
  std::map<std::string, Sums> sums;
  for (int plant = 0; plant < plants; ++plant) {
    Campaign campaign(static_cast<std::uint64_t>(first + plant), rest_s);
    const auto made = three_sessions(campaign);
    const auto all = campaign.session("all", {"x", "y", "z", "rx", "ry", "rz"});
    const auto joined = join({made.first.part, made.second.part, made.third.part}, {});
    ASSERT_TRUE(joined) << joined.error().message;
    for (const auto& channel : joined->report.channels) {
      if (!channel.u) continue;
      const auto& symbol = channel.channel.symbol;
      const double at_once = rms_error(all.part.data, symbol, all);
      const double u = (symbol.size() == 1 ? 1e6 : 1) * *channel.u;
      const double error = rms_error(joined->data, symbol, mean_truth(made, symbol));
      auto& sum = sums[symbol];
      sum.error2 += error * error;
      sum.u2 += u * u;
      sum.worst = std::max(sum.worst, error / u);
      sum.at_once2 += at_once * at_once;
      sum.within += error <= 2 * u ? 1 : 0;
      sum.as_at_once += error <= std::hypot(at_once, 2 * u) ? 1 : 0;
      std::printf("plant %d %-2s error %6.3f u %6.3f at once %6.3f\n", first + plant,
                  symbol.c_str(), error, u, at_once);
    }
  }
  std::printf("%-4s %10s %10s %8s %12s %12s %10s %24s %10s\n", "", "rms error", "stated u", "ratio",
              "worst plant", "within 2 u", "at once", "to sqrt(at once^2 + u^2)", "within 2 u");
  for (const auto& [symbol, sum] : sums) {
    const double to_at_once = std::sqrt(sum.error2 / (sum.at_once2 + sum.u2));
    std::printf("%-4s %10.3f %10.3f %8.2f %12.2f %6d of %2d %10.3f %24.2f %4d of %2d\n",
                symbol.c_str(), std::sqrt(sum.error2 / plants), std::sqrt(sum.u2 / plants),
                std::sqrt(sum.error2 / sum.u2), sum.worst, sum.within, plants,
                std::sqrt(sum.at_once2 / plants), to_at_once, sum.as_at_once, plants);
    EXPECT_LT(std::sqrt(sum.error2 / sum.u2), 1.5) << symbol;
    // A length also has the error of its lever arm, known to 0.5 mm, times the tilt: six
    // coordinates measured at once have it too, and it is no part of the join's u.
    EXPECT_LT(to_at_once, 1.2) << symbol;
    EXPECT_EQ(sum.as_at_once, plants) << symbol;
    if (symbol.size() > 1) {
      EXPECT_EQ(sum.within, plants) << symbol;
    }
  }
}

TEST(DeltaCubeSessions, JoinedAreAsGoodAsSixCoordinatesAtOnceWithinTheStatedUncertainty) {
  const auto& made = sessions();
  const auto joined = join({made.first.part, made.second.part, made.third.part}, {});
  ASSERT_TRUE(joined) << joined.error().message;
  const std::map<std::string, const Session*> measured_in{{"x", &made.first},  {"y", &made.second},
                                                          {"z", &made.third},  {"rx", &made.second},
                                                          {"ry", &made.first}, {"rz", &made.first}};
  for (const auto& channel : joined->report.channels) {
    const auto& symbol = channel.channel.symbol;
    if (!measured_in.contains(symbol)) continue;
    ASSERT_TRUE(channel.u) << symbol;
    const double u = (symbol.size() == 1 ? 1e6 : 1) * *channel.u;
    const double by_join = rms_error(joined->data, symbol, *measured_in.at(symbol));
    const double at_once = rms_error(made.all.part.data, symbol, made.all);
    std::printf("%-3s joined %7.2f, at once %7.2f, stated u %7.2f\n", symbol.c_str(), by_join,
                at_once, u);
    EXPECT_LT(by_join, std::hypot(at_once, 2 * u)) << symbol;
    EXPECT_LT(by_join, 3 * u) << symbol;
  }
}

TEST(DeltaCubeSessions, AreRefusedWithTheRowsOfOneShifted) {
  const auto& made = sessions();
  auto shifted = made.second.part;
  for (auto& column : shifted.data.columns)
    if (!column.channel.symbol.starts_with("q"))
      std::rotate(column.values.begin() + 1, column.values.begin() + 2, column.values.end());
  const auto joined = join({made.first.part, shifted, made.third.part}, {});
  ASSERT_FALSE(joined);
  EXPECT_EQ(joined.error().reason, "ROWS_SHIFTED") << joined.error().message;
}

TEST(DeltaCubeSessions, AreRefusedWithTheAnglesOfTwoSetUpsSwapped) {
  const auto& made = sessions();
  auto swapped = made.second.part;
  for (auto& column : swapped.data.columns)
    column.channel.symbol = column.channel.symbol == "rx"   ? "ry"
                            : column.channel.symbol == "ry" ? "rx"
                                                            : column.channel.symbol;
  const auto joined = join({made.first.part, swapped, made.third.part}, {});
  ASSERT_FALSE(joined);
  EXPECT_EQ(joined.error().reason, "SETUPS_SWAPPED") << joined.error().message;
}

}  // namespace
}  // namespace driftwise::correction
