#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
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

  const char* unit() const { return shown > 1 ? "nm" : "arcsec"; }
  double sources() const { return static_cast<double>(std::ranges::count(seen, true)); }
};
constexpr std::array<JoinedCoordinate, 6> kJoined{
    {{"x", "x_nm", "u_nm", 1e-6, 1e6, {true, false, false}},
     {"y", "y_nm", "u_nm", 1e-6, 1e6, {false, true, false}},
     {"z", "z_nm", "u_nm", 1e-6, 1e6, {false, false, true}},
     {"rx", "rx_arcsec", "u_arcsec", 1, 1, {false, true, false}},
     {"ry", "ry_arcsec", "u_arcsec", 1, 1, {true, true, false}},
     {"rz", "rz_arcsec", "u_arcsec", 1, 1, {true, false, false}}}};

// An exported run.
struct Session {
  Session(const std::string& folder, const std::string& name)
      : path(folder + "/" + name + ".csv"), data(read_dataset(path)) {}
  std::string path;
  Dataset data;
};

// For each row of the joined data the row of a session at the same place. Several rows at one place
// (returns to zero): in the order of their visits.
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

// The symbol's column and the returns to zero in the rows given, in their order.
Dataset rows_of(const Dataset& data, const std::vector<std::size_t>& rows) {
  Dataset out;
  out.rows = rows.size();
  for (const auto& column : data.columns) {
    out.columns.push_back({column.channel, {}});
    for (const auto row : rows) out.columns.back().values.push_back(column.values[row]);
  }
  for (const auto row : rows) out.zero.push_back(is_zero_row(data, row) ? 1 : 0);
  return out;
}

// Less the mean of the returns to zero.
void align_at_returns(const Dataset& rows, std::vector<double>& values) {
  double sum = 0, count = 0;
  for (std::size_t row = 0; row < rows.rows; ++row)
    if (is_zero_row(rows, row)) sum += values[row], count += 1;
  for (double& value : values) value -= sum / count;
}

// Place of the cube in one session, by rows of the joined data; in the joined column's unit.
std::vector<double> true_values_of(const Dataset& joined, const Session& session,
                                   const TruthTable& truth, const JoinedCoordinate& one) {
  const TruthOfRun true_pose(session.data, session.path, truth);
  std::vector<double> values;
  for (const auto row : rows_at_places_of(joined, session.data))
    values.push_back(one.per_truth * true_pose.at(one.truth, row));
  align_at_returns(joined, values);
  return values;
}

// Measured less true, nm or arcsec.
std::vector<double> errors_of(const std::vector<double>& measured, const JoinedCoordinate& one,
                              const std::vector<double>& true_values) {
  std::vector<double> errors;
  for (std::size_t row = 0; row < measured.size(); ++row)
    errors.push_back(one.shown * (measured[row] - true_values[row]));
  return errors;
}

double rms_of(const std::vector<double>& values) {
  double squares = 0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

double largest_of(const std::vector<double>& values) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

const nlohmann::json& channel_of(const nlohmann::json& report, const JoinedCoordinate& one) {
  const std::string name = std::string(one.symbol) + (one.shown > 1 ? "_mm" : "_arcsec");
  for (const auto& channel : report.at("channels"))
    if (channel.at("channel") == name) return channel;
  throw std::runtime_error("join.json: no channel " + name);
}
double stated_u(const nlohmann::json& report, const JoinedCoordinate& one) {
  return figure(channel_of(report, one), one.key);
}
// Sigma of the difference of two sessions; NaN: one session measured it.
double seen_twice(const nlohmann::json& report, const JoinedCoordinate& one) {
  const auto& channel = channel_of(report, one);
  const auto check = channel.find("check");
  if (check == channel.end() || !check->is_object()) return NAN;
  return figure(*check, one.shown > 1 ? "sigma_nm" : "sigma_arcsec");
}

}  // namespace

void print_delta_cube_join(const std::string& folder) {
  const TruthTable truth(folder + "/truth.csv");
  const auto report = read_json(folder + "/join.json").at("report");
  Dataset joined = read_dataset(folder + "/joined.csv");
  std::vector<Session> sessions;
  for (const char* name : {"configuration-1", "configuration-2", "configuration-3"})
    sessions.emplace_back(folder, name);
  const bool has_at_once = std::filesystem::exists(folder + "/at_once.csv");
  std::optional<Session> at_once;
  if (has_at_once) at_once.emplace(folder, "at_once");

  std::printf(
      "\nThe joined pose against the plant's truth at the joined motor coordinates (the mean of "
      "the "
      "three sessions'), zeros at the mean of the returns\n"
      "  %-12s%12s%18s%10s%10s%20s%s\n",
      "", "stated u", "true error, rms", "error/u", "largest", "seen twice: sigma",
      has_at_once ? "   six at once, rms   joined less at once, rms" : "");
  nlohmann::json figures = nlohmann::json::object();
  std::array<std::vector<double>, 6> true_values;
  for (std::size_t k = 0; k < kJoined.size(); ++k) {
    const auto& one = kJoined[k];
    // A joined row has the mean motor coordinates of its three sessions, so it is judged where the
    // cube was in their mean. They are 100 nm apart at most.
    std::vector<double> mean(joined.rows, 0), where_measured(joined.rows, 0);
    for (std::size_t s = 0; s < sessions.size(); ++s) {
      const auto there = true_values_of(joined, sessions[s], truth, one);
      for (std::size_t row = 0; row < joined.rows; ++row) {
        mean[row] += there[row] / static_cast<double>(sessions.size());
        if (one.seen[s]) where_measured[row] += there[row] / one.sources();
      }
    }
    const auto& values = need_column(joined, one.symbol).values;
    const auto error = errors_of(values, one, mean);
    const double u = stated_u(report, one), check = seen_twice(report, one);
    std::printf("  %-4s%-8s%12.2f%18.2f%10.2f%10.2f", one.symbol, one.unit(), u, rms_of(error),
                rms_of(error) / u, largest_of(error));
    if (std::isfinite(check))
      std::printf("%20.2f", check);
    else if (at_once)
      std::printf("%20s", "");
    auto& of = figures[one.symbol];
    of = {{"unit", one.unit()},
          {"u", u},
          {"rms", rms_of(error)},
          {"largest", largest_of(error)},
          {"rms_where_measured", rms_of(errors_of(values, one, where_measured))}};
    if (at_once) {
      const auto rows = rows_at_places_of(joined, at_once->data);
      const Dataset there = rows_of(at_once->data, rows);
      auto seen = need_column(there, one.symbol).values;
      align_at_returns(there, seen);
      const auto other = errors_of(seen, one, true_values_of(joined, *at_once, truth, one));
      std::vector<double> less;
      for (std::size_t row = 0; row < joined.rows; ++row) less.push_back(error[row] - other[row]);
      std::printf("%21.2f%27.2f", rms_of(other), rms_of(less));
      of["at_once_rms"] = rms_of(other);
      of["less_at_once_rms"] = rms_of(less);
    }
    std::printf("\n");
    true_values[k] = std::move(mean);
  }
  std::ofstream(folder + "/join_truth.json") << figures.dump(1) << "\n";
  // Calibration rows as measured, validation rows where the cube really was at their motor
  // coordinates.
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
      "\nModels on the joined data: A90 (mean, S90) in nm on the rows between the grid's\n"
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
