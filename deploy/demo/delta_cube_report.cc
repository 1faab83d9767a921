#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "deploy/demo/figures.h"
#include "deploy/demo/reports.h"
#include "server/formats/csv/dataset_csv.h"

namespace driftwise::demo {
namespace {

struct JoinedCoordinate {
  const char *symbol, *truth, *key;
  double per_truth;          // the column's unit per truth's
  double shown;              // nm or arcsec per the column's unit
  std::array<bool, 3> seen;  // by the configurations
};
constexpr std::array<JoinedCoordinate, 6> kJoined{
    {{"x", "x_nm", "u_nm", 1e-6, 1e6, {true, false, false}},
     {"y", "y_nm", "u_nm", 1e-6, 1e6, {false, true, false}},
     {"z", "z_nm", "u_nm", 1e-6, 1e6, {false, false, true}},
     {"rx", "rx_arcsec", "u_arcsec", 1, 1, {false, true, false}},
     {"ry", "ry_arcsec", "u_arcsec", 1, 1, {true, true, false}},
     {"rz", "rz_arcsec", "u_arcsec", 1, 1, {true, false, false}}}};

// The three sessions, and for each row of the joined data the row of a session that stood there.
struct Session {
  Session(const std::string& folder, int number)
      : path(folder + "/configuration-" + std::to_string(number) + ".csv"),
        data(read_dataset(path)) {}
  std::string path;
  Dataset data;
};

// Where several rows stand at one place (returns to zero), in the order of their visits.
std::vector<std::size_t> rows_at_places_of(const Dataset& joined, const Dataset& session) {
  const auto place = [](const Dataset& data, std::size_t row) {
    std::array<long, 3> key{};
    const auto q = commanded_mm(data, row);
    for (std::size_t i = 0; i < 3; ++i) key[i] = std::lround(1e5 * q[i]);
    return key;
  };
  std::map<std::array<long, 3>, std::vector<std::size_t>> there;
  for (std::size_t row = 0; row < session.rows; ++row) there[place(session, row)].push_back(row);
  std::map<std::array<long, 3>, std::size_t> used;
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < joined.rows; ++row) {
    const auto key = place(joined, row);
    const auto& found = there[key];
    if (found.empty()) throw std::runtime_error("a joined row stands where no session stood");
    rows.push_back(found[std::min(used[key]++, found.size() - 1)]);
  }
  return rows;
}

}  // namespace

void print_delta_cube_join(const std::string& folder) {
  const TruthTable truth(folder + "/truth.csv");
  const auto report = read_json(folder + "/join.json").at("report");
  Dataset joined = read_dataset(folder + "/joined.csv");
  std::printf(
      "\nThe joined pose against the plant's truth, each session counted from its own returns to "
      "zero\n  %-12s%14s%16s%16s%20s\n",
      "", "stated u", "true error, rms", "largest", "seen twice: sigma");
  std::array<std::vector<double>, 6> true_values;
  std::array<int, 6> sessions_of{};
  for (auto& values : true_values) values.assign(joined.rows, 0);
  for (int number = 1; number <= 3; ++number) {
    const Session session(folder, number);
    const TruthOfRun true_pose(session.data, session.path, truth);
    const auto rows = rows_at_places_of(joined, session.data);
    for (std::size_t k = 0; k < kJoined.size(); ++k) {
      if (!kJoined[k].seen[static_cast<std::size_t>(number - 1)]) continue;
      ++sessions_of[k];
      // Zeros are aligned at the median of the returns, as the join does.
      std::vector<double> values(joined.rows), returns;
      for (std::size_t row = 0; row < joined.rows; ++row) {
        values[row] = true_pose.at(kJoined[k].truth, rows[row]);
        if (is_zero_row(joined, row)) returns.push_back(values[row]);
      }
      std::ranges::sort(returns);
      const double zero = returns.empty() ? 0 : returns[returns.size() / 2];
      for (std::size_t row = 0; row < joined.rows; ++row)
        true_values[k][row] += kJoined[k].per_truth * (values[row] - zero);
    }
  }
  for (std::size_t k = 0; k < kJoined.size(); ++k) {
    const auto& one = kJoined[k];
    const auto& measured = need_column(joined, one.symbol).values;
    double squares = 0, largest = 0;
    for (std::size_t row = 0; row < joined.rows; ++row) {
      true_values[k][row] /= sessions_of[k];
      const double error = one.shown * (measured[row] - true_values[k][row]);
      squares += error * error;
      largest = std::max(largest, std::abs(error));
    }
    double u = NAN, check = NAN;
    for (const auto& channel : report.at("channels")) {
      const auto name = channel.at("channel").get<std::string>();
      if (name != std::string(one.symbol) + (one.shown > 1 ? "_mm" : "_arcsec")) continue;
      u = figure(channel, one.key);
      if (channel.contains("check") && channel.at("check").is_object())
        check = figure(channel.at("check"), one.shown > 1 ? "sigma_nm" : "sigma_arcsec");
    }
    const char* unit = one.shown > 1 ? "nm" : "arcsec";
    std::printf("  %-4s%-8s%14.2f%16.2f%16.2f", one.symbol, unit, u,
                std::sqrt(squares / static_cast<double>(joined.rows)), largest);
    if (std::isfinite(check))
      std::printf("%20.2f\n", check);
    else
      std::printf("\n");
  }
  // Calibration rows as measured, validation rows where the cube really was.
  for (std::size_t k = 0; k < kJoined.size(); ++k)
    for (auto& column : joined.columns)
      if (column.channel.symbol == kJoined[k].symbol)
        for (std::size_t row = 0; row < joined.rows; ++row)
          if (joined.set_of(row) == PointSet::validation) column.values[row] = true_values[k][row];
  std::ofstream file(folder + "/at_truth.csv");
  file << formats::write_dataset_csv(joined);
  if (!file.flush()) throw std::runtime_error(folder + "/at_truth.csv cannot be written");
}

void print_delta_cube_methods(const std::string& folder) {
  const auto measured = read_json(folder + "/methods.json");
  const auto at_truth = read_json(folder + "/methods_truth.json");
  std::printf(
      "\nModels on the joined data: A90 (mean, U90) in nm on the rows between the grid's\n"
      "  %-31s%11s  %-13s%-24s%-24s\n",
      "", "parameters", "predecessors", "here: instruments", "here: truth");
  const std::map<std::string, std::pair<const char*, const char*>> words{
      {"nominal", {"the drawing", ""}},
      {"kinematic", {"model-based, geometry", "+-100"}},
      {"classic", {"model-based, IGM + error", "+-100"}},
      {"stepwise", {"model-free", "below +-100"}}};
  const auto& methods = measured.at("methods");
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const auto& [label, published] = words.at(methods[m].at("method").get<std::string>());
    bool first = true;
    for (const auto& [q, output] : methods[m].at("outputs").items()) {
      const auto& truth = at_truth.at("methods")[m].at("outputs").at(q);
      const auto cell = [](const nlohmann::json& one) {
        return text(ErrorFigures{.mean = figure(one, "mean_validation_nm"),
                                 .u90 = figure(one, "u90_validation_nm"),
                                 .a90 = figure(one, "a90_validation_nm")});
      };
      std::printf("  %-27s%-4s%11.0f  %-13s%-24s%-24s\n", first ? label : "", q.c_str(),
                  figure(output, "parameters"), first ? published : "", cell(output).c_str(),
                  cell(truth).c_str());
      first = false;
    }
  }
}

}  // namespace driftwise::demo
