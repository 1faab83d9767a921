// The whole of a real file: the UR10 of tests/data/ur10_laser_tracker by the mappings in
// deploy/mappings, held against R's reading of the same bytes.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <sstream>

#include "server/core/units.h"
#include "server/formats/import/import_dataset.h"
#include "server/formats/import/mapping_file.h"

namespace driftwise::formats {
namespace {

std::string read_whole(const std::string& path) {
  std::ifstream file(std::string(DRIFTWISE_SOURCE_DIR) + "/" + path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

ImportedDataset series(const std::string& letter, const std::string& file) {
  const auto mapping = read_import_mapping(
      read_whole("deploy/mappings/ur10_laser_tracker_" + letter + ".toml"), letter + ".toml");
  EXPECT_TRUE(mapping) << mapping.error().message;
  auto out = import_dataset(read_whole("tests/data/ur10_laser_tracker/" + file + ".csv.gz"), file,
                            *mapping);
  EXPECT_TRUE(out) << out.error().message;
  return std::move(*out);
}

struct Sums {
  double count, sum, squares, weighted, first, last;
};

std::map<std::string, Sums> sums_by_r(const std::string& file) {
  std::istringstream lines(read_whole("tests/data/ur10_laser_tracker/read_by_r.csv"));
  std::map<std::string, Sums> out;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::string series, column, number;
    std::getline(fields, series, ',');
    std::getline(fields, column, ',');
    if (series != file) continue;
    std::vector<double> numbers;
    while (std::getline(fields, number, ',')) numbers.push_back(std::stod(number));
    out[column] = {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]};
  }
  return out;
}

// factor: from the file's unit to the dataset's.
void expect_the_sums(const std::vector<double>& values, const Sums& r, double factor,
                     const std::string& name) {
  ASSERT_EQ(static_cast<double>(values.size()), r.count) << name;
  long double sum = 0, squares = 0, weighted = 0, scale = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const long double value = values[i] / factor;
    sum += value, squares += value * value, weighted += value * (i + 1.0L);
    scale += std::abs(value);
  }
  // R adds in long double too and prints 17 digits: what differs is the last digit of each value.
  const double slack = 4e-16 * static_cast<double>(scale);
  EXPECT_NEAR(static_cast<double>(sum), r.sum, slack) << name;
  EXPECT_NEAR(static_cast<double>(squares), r.squares, 1e-15 * r.squares) << name;
  EXPECT_NEAR(static_cast<double>(weighted), r.weighted, slack * static_cast<double>(values.size()))
      << name;
  EXPECT_NEAR(values.front() / factor, r.first, 1e-15 * std::abs(r.first)) << name;
  EXPECT_NEAR(values.back() / factor, r.last, 1e-15 * std::abs(r.last)) << name;
}

void expect_what_r_read(const ImportedDataset& imported, const std::string& file) {
  const auto expected = sums_by_r(file);
  ASSERT_FALSE(expected.empty());
  std::size_t compared = 0;
  for (const auto& column : imported.report.columns) {
    const std::string symbol = column.channel.substr(0, column.channel.rfind('_'));
    const double factor = (column.unit == "m")                                          ? 1e3
                          : column.channel.ends_with("_std_nm")                         ? 1e6
                          : column.unit == "deg" && column.channel.ends_with("_arcsec") ? 3600
                                                                                        : 1;
    expect_the_sums(imported.dataset.find(symbol)->values, expected.at(column.source), factor,
                    column.channel);
    ++compared;
  }
  if (!imported.dataset.time_s.empty())
    expect_the_sums(imported.dataset.time_s, expected.at("Timestamp"), 1, "time_s");
  EXPECT_EQ(compared + !imported.dataset.time_s.empty(), expected.size());
}

TEST(Ur10SeriesA, ComesInWholeWithItsGoals) {
  const auto imported = series("a", "series_a_grid");
  EXPECT_EQ(imported.dataset.rows, 11911U);
  EXPECT_EQ(imported.report.groups, 619U);
  EXPECT_EQ(imported.report.median_group, 22);
  EXPECT_EQ(imported.report.largest_group, 23U);
  EXPECT_NEAR(imported.dataset.time_s.back() / 86400, 4.2, 0.05);
  expect_what_r_read(imported, "series_a_grid");
}

TEST(Ur10SeriesD, ComesInWholeWithoutItsUselessStamps) {
  const auto imported = series("d", "series_d_iso_cubes");
  EXPECT_EQ(imported.dataset.rows, 632U);
  EXPECT_TRUE(imported.dataset.time_s.empty());
  expect_what_r_read(imported, "series_d_iso_cubes");
}

// Frames and tools drop out of the angle between two rows: goal and tracker agree about it when
// both conventions are right (the goals turn about one axis at a time, so that theirs hardly
// shows), to what the robot's orientation is wrong by (0.1 degree or so).
double median_disagreement_deg(const Dataset& data, RotationConvention goal,
                               RotationConvention tracker) {
  const auto rotation = [&](const char* a, const char* b, const char* c, std::size_t row,
                            RotationConvention convention, double rad_per_unit) {
    return rotation_matrix(convention,
                           Eigen::Vector3d(data.find(a)->values[row], data.find(b)->values[row],
                                           data.find(c)->values[row]) *
                               rad_per_unit);
  };
  const auto angle_deg = [](const Eigen::Matrix3d& r) {
    return std::acos(std::clamp((r.trace() - 1) / 2, -1.0, 1.0)) / kRadPerDeg;
  };
  std::mt19937 random(11911);
  std::vector<double> differences;
  for (int i = 0; i < 1000; ++i) {
    const std::size_t one = random() % data.rows, two = random() % data.rows;
    const Eigen::Matrix3d goals =
        rotation("goal_rx", "goal_ry", "goal_rz", one, goal, 1).transpose() *
        rotation("goal_rx", "goal_ry", "goal_rz", two, goal, 1);
    const Eigen::Matrix3d seen = rotation("rx", "ry", "rz", one, tracker, kRadPerDeg).transpose() *
                                 rotation("rx", "ry", "rz", two, tracker, kRadPerDeg);
    differences.push_back(std::abs(angle_deg(goals) - angle_deg(seen)));
  }
  std::ranges::nth_element(differences, differences.begin() + 500);
  return differences[500];
}

TEST(Ur10SeriesA, SpeaksOfRotationsAsTheMappingSays) {
  const auto data = series("a", "series_a_grid").dataset;
  const double said =
      median_disagreement_deg(data, RotationConvention::xyz_fixed, RotationConvention::xyz_moving);
  EXPECT_LT(said, 0.15);
  EXPECT_GT(
      median_disagreement_deg(data, RotationConvention::xyz_fixed, RotationConvention::xyz_fixed),
      2 * said);
}

}  // namespace
}  // namespace driftwise::formats
