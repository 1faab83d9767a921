#include "deploy/demo/figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "server/core/cell_time.h"
#include "server/core/data/row_marks.h"
#include "server/formats/csv/dataset_csv.h"

namespace driftwise::demo {

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

nlohmann::json read_json(const std::string& path) { return nlohmann::json::parse(read_file(path)); }

Dataset read_dataset(const std::string& path) {
  auto data = formats::read_dataset_csv(read_file(path), path);
  if (!data) throw std::runtime_error(data.error().message);
  leave_passages_out(*data);
  return std::move(*data);
}

double figure(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : std::nan("");
}

int terms_in(const nlohmann::json& output) {
  int in = 0;
  for (const auto& term : output.at("terms")) in += term.at("in").get<bool>() ? 1 : 0;
  return in;
}

std::string text(const ErrorFigures& figures) {
  char out[48];
  std::snprintf(out, sizeof out, "%.1f (%+.1f, %.1f)", figures.a90, figures.mean, figures.u90);
  return out;
}

ByInstrument by_instrument(const nlohmann::json& verification, const std::string& coordinate) {
  const auto figures = [](const nlohmann::json& of) {
    return ErrorFigures{.rows = of.at("row_count").get<std::int64_t>(),
                        .mean = of.at("mean").get<double>(),
                        .u90 = of.at("u90").get<double>(),
                        .a90 = of.at("a90").get<double>()};
  };
  for (const auto& one : verification.at("runs").at(0).at("coordinates"))
    if (one.at("coordinate") == coordinate) {
      ByInstrument found{figures(one.at("all")), std::nullopt};
      if (one.at("by_model").is_object()) found.by_model = figures(one.at("by_model"));
      return found;
    }
  throw std::runtime_error("the verification has no coordinate " + coordinate);
}

std::int64_t time_zero_ns(const Dataset& data, const std::string& path) {
  for (const auto& [key, value] : data.metadata)
    if (key == "time_zero")
      if (const auto time = parse_iso8601(value)) return time->utc_ns;
  throw std::runtime_error(path + ": no '# time_zero:' line");
}

TruthTable::TruthTable(const std::string& path) {
  std::istringstream file(read_file(path));
  std::size_t kind = 0, time = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream fields(line);
    for (std::string cell; std::getline(fields, cell, ',');) cells.push_back(cell);
    if (columns_.empty()) {
      for (std::size_t i = 0; i < cells.size(); ++i) columns_[cells[i]] = i;
      kind = columns_.at("kind");
      time = columns_.at("time_ns");
      continue;
    }
    Row row{std::stoll(cells.at(time)), cells.at(kind) == "zero", cells.at(kind) == "length", {}};
    for (std::size_t i = 0; i < cells.size(); ++i)
      row.values.push_back(i == kind ? 0.0 : std::stod(cells[i]));
    rows_.push_back(std::move(row));
  }
  std::ranges::stable_sort(rows_, {}, &Row::time_ns);
}

std::size_t TruthTable::column(const std::string& name) const {
  const auto found = columns_.find(name);
  if (found == columns_.end()) throw std::runtime_error("the plant's log has no column " + name);
  return found->second;
}

double TruthTable::at_zero(const std::string& name, std::int64_t until_ns) const {
  const auto index = column(name);
  double value = std::nan("");
  for (const auto& row : rows_)
    if (row.zero && row.time_ns <= until_ns) value = row.values.at(index);
  return value;
}

std::int64_t half_of_shortest_step_ns(const Dataset& data) {
  double shortest_s = INFINITY;
  for (std::size_t i = 1; i < data.rows; ++i)
    shortest_s = std::min(shortest_s, data.time_s[i] - data.time_s[i - 1]);
  return std::isfinite(shortest_s) ? static_cast<std::int64_t>(shortest_s * 5e8) : 0;
}

double TruthTable::mean_about(const std::string& name, std::int64_t middle_ns,
                              std::int64_t late_ns) const {
  constexpr std::int64_t kNear_ns = 3'000'000'000;
  const auto index = column(name);
  const auto mean_near = [&](std::int64_t at_ns) -> std::optional<double> {
    double sum = 0;
    int count = 0;
    for (auto row = std::ranges::lower_bound(rows_, at_ns - kNear_ns + 1, {}, &Row::time_ns);
         row != rows_.end() && row->time_ns < at_ns + kNear_ns; ++row)
      if (row->length) sum += row->values.at(index), ++count;
    return count > 0 ? std::optional(sum / count) : std::nullopt;
  };
  if (const auto mean = mean_near(middle_ns)) return *mean;
  std::int64_t nearest_ns = rows_.empty() ? 0 : rows_.front().time_ns;
  for (const auto& row : rows_)
    if (row.length && std::abs(row.time_ns - middle_ns) < std::abs(nearest_ns - middle_ns))
      nearest_ns = row.time_ns;
  const auto mean = mean_near(nearest_ns);
  const auto away_ns = std::abs(nearest_ns - middle_ns);
  if (!mean || away_ns > late_ns)
    throw std::runtime_error(
        "the plant's log has no row of a point's readings: the nearest is " +
        std::to_string(away_ns / 1'000'000'000) + " s of cell time away, expected at most " +
        std::to_string(late_ns / 1'000'000'000) + " s: run the demo on a computer with less to do");
  return *mean;
}

double TruthTable::mean_at_rest(const std::string& name, std::int64_t middle_ns,
                                const std::array<double, 3>& commanded_mm) const {
  constexpr std::int64_t kNear_ns = 30'000'000'000;
  constexpr double kCommanded_nm = 2, kRest_nm = 1000, kNmOfMm = 1e6;
  std::array<std::size_t, 3> commanded{}, scale{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string axis = "q" + std::to_string(i + 1);
    commanded[i] = column(axis + "_commanded_nm");
    scale[i] = column(axis + "_scale_nm");
  }
  const auto rests = [&](const Row& row) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double target_nm = kNmOfMm * commanded_mm[i];
      if (std::abs(row.values.at(commanded[i]) - target_nm) > kCommanded_nm ||
          std::abs(row.values.at(scale[i]) - target_nm) > kRest_nm)
        return false;
    }
    return true;
  };
  const auto index = column(name);
  double sum = 0;
  int count = 0;
  for (auto row = std::ranges::lower_bound(rows_, middle_ns - kNear_ns, {}, &Row::time_ns);
       row != rows_.end() && row->time_ns < middle_ns + kNear_ns; ++row)
    if (rests(*row)) sum += row->values.at(index), ++count;
  if (count == 0) throw std::runtime_error("the plant's log has no row at rest for a point");
  return sum / count;
}

const DatasetColumn& need_column(const Dataset& data, const std::string& symbol) {
  const auto* column = data.find(symbol);
  if (!column) throw std::runtime_error("a run has no column " + symbol);
  return *column;
}

bool is_zero_row(const Dataset& data, std::size_t row) {
  return !data.zero.empty() && data.zero[row] != 0;
}

std::array<double, 3> commanded_mm(const Dataset& data, std::size_t row) {
  return {need_column(data, "q1_cmd").values[row], need_column(data, "q2_cmd").values[row],
          need_column(data, "q3_cmd").values[row]};
}

}  // namespace driftwise::demo
