// The demo's tables: the published study beside ours, from what the daemon and the command line
// printed. It computes nothing but differences and standard deviations; fits, predictions and
// targets are the daemon's.
//
//   driftwise-demo-report fits FOLDER     geometry.json, first300.json, six.json, ten.json,
//   offers.json driftwise-demo-report proof FOLDER    none.csv, ten.csv, six.csv (exported runs)
//   and truth.csv (the plant's private log)

#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/units.h"
#include "server/formats/dataset_csv.h"

namespace {

using driftwise::Dataset;
using nlohmann::json;

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// ---- the fits
// -----------------------------------------------------------------------------------------------------

double figure(const json& output, const char* key) {
  const auto found = output.find(key);
  return found != output.end() && found->is_number() ? found->get<double>() : NAN;
}

std::string dropped_sensors(const json& output) {
  std::string names;
  for (const auto& term : output.at("terms"))
    if (!term.at("in").get<bool>())
      names += (names.empty() ? "" : " ") + term.at("term").get<std::string>();
  return names.empty() ? "none" : names;
}

void print_fits(const std::string& folder) {
  struct Row {
    const char *label, *file, *published;
  };
  const Row rows[] = {{"geometry only", "geometry", "206"},
                      {"geometry + 10 temperatures", "ten", "9"},
                      {"only the 6 sensors on the robot", "six", "15"},
                      {"first 300 points only, 10 temperatures", "first300", "40"}};
  std::printf(
      "\nU90 in nm on points that took no part in the fit        published    here: validation   "
      "held out by    terms   fit\n");
  std::printf("%-56s%9s    %17s   %-15s%5s\n", "", "2011", "(half millimetres)", "blocks of time",
              "in");
  for (const Row& row : rows) {
    const json fit = json::parse(read_file(folder + "/" + row.file + ".json"));
    const json& q1 = fit.at("outputs").at("q1");
    int in = 0;
    for (const auto& term : q1.at("terms")) in += term.at("in").get<bool>() ? 1 : 0;
    std::printf("%-56s%9s    %17.1f   %-15.1f%5d   %.2f ms\n", row.label, row.published,
                figure(q1, "u90_validation_nm"), figure(q1, "u90_blocks_nm"), in,
                fit.at("fit_us").get<double>() / 1000);
  }
  const json ten = json::parse(read_file(folder + "/ten.json"));
  std::printf(
      "\ncalibration %lld points, validation %lld points, U90 on the calibration points %.1f nm "
      "(published 9)\n",
      ten.at("rows").at("calibration").get<long long>(),
      ten.at("rows").at("validation").get<long long>(),
      figure(ten.at("outputs").at("q1"), "u90_calibration_nm"));
  std::printf("dropped by the regression: %s (published: the stabilised base, the lower arm)\n",
              dropped_sensors(ten.at("outputs").at("q1")).c_str());
  const json offers = json::parse(read_file(folder + "/offers.json"));
  std::printf(
      "\nmore terms, and what each would change in the held-out U90 (published: all rejected, 4th "
      "order got stuck)\n");
  for (const auto& offer : offers.at("offers")) {
    const double before = figure(offer, "u90_validation_before_nm"),
                 after = figure(offer, "u90_validation_after_nm");
    const double blocks_before = figure(offer, "u90_blocks_before_nm"),
                 blocks_after = figure(offer, "u90_blocks_after_nm");
    std::string taken;
    for (const auto& term : offer.at("taken"))
      taken += (taken.empty() ? "" : " ") + term.get<std::string>();
    if (taken.empty())
      std::printf("  %-48s all rejected: +0.0 nm\n", offer.at("offer").get<std::string>().c_str());
    else
      std::printf("  %-48s %+.1f nm, by blocks of time %+.1f nm; stepwise takes %s\n",
                  offer.at("offer").get<std::string>().c_str(), after - before,
                  blocks_after - blocks_before, taken.c_str());
  }
}

// ---- the proof
// ----------------------------------------------------------------------------------------------------

struct TruthRow {
  std::int64_t time_ns = 0;
  bool zero = false, length = false;
  double end_effector_nm = 0;
};

std::vector<TruthRow> read_truth(const std::string& path) {
  std::istringstream file(read_file(path));
  std::string line, cell;
  std::map<std::string, std::size_t> column;
  std::vector<TruthRow> rows;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream fields(line);
    while (std::getline(fields, cell, ',')) cells.push_back(cell);
    if (column.empty()) {
      for (std::size_t i = 0; i < cells.size(); ++i) column[cells[i]] = i;
      continue;
    }
    TruthRow row;
    row.time_ns = std::stoll(cells.at(column.at("time_ns")));
    row.zero = cells.at(column.at("kind")) == "zero";
    row.length = cells.at(column.at("kind")) == "length";
    row.end_effector_nm = std::stod(cells.at(column.at("end_effector_nm")));
    rows.push_back(row);
  }
  return rows;
}

struct Spread {
  double mean_nm = 0, u90_nm = 0;
};

Spread spread(const std::vector<double>& errors_nm) {
  Spread out;
  for (const double e : errors_nm) out.mean_nm += e / static_cast<double>(errors_nm.size());
  double square = 0;
  for (const double e : errors_nm) square += (e - out.mean_nm) * (e - out.mean_nm);
  out.u90_nm =
      driftwise::kSigmaToU90 * std::sqrt(square / static_cast<double>(errors_nm.size() - 1));
  return out;
}

// instrument, truth: where the axis came to rest. The model_* figures leave out how far the axis
// rested from its own command (its holding error, read back from the scale): what the model alone
// is responsible for.
struct Proof {
  std::size_t points = 0;
  Spread instrument, truth, model_by_instrument, model_in_truth;
  double air_change_k = 0;
};

// Where the end-effector was at each accepted point, relative to the run's zero: the mean of the
// plant's rows that belong to its readings.
Proof judge(const std::string& csv_path, const std::vector<TruthRow>& truth) {
  const auto data = driftwise::formats::read_dataset_csv(read_file(csv_path), csv_path);
  if (!data) throw std::runtime_error(data.error().message);
  std::string started;
  for (const auto& [key, value] : data->metadata)
    if (key == "time_zero") started = value;
  const auto zero_time = driftwise::parse_iso8601(started);
  if (!zero_time) throw std::runtime_error(csv_path + ": no '# time_zero:' line");
  const auto* x = data->find("x");
  const auto* wanted = data->find("x_target") ? data->find("x_target") : data->find("q1_cmd");
  const auto* air = data->find("t04");
  const auto* q = data->find("q1");
  const auto* q_cmd = data->find("q1_cmd");
  if (!x || !wanted || !q || !q_cmd)
    throw std::runtime_error(csv_path + ": no x_mm, q1_mm or wanted position");

  double at_zero_nm = NAN;  // the end-effector when the interferometer was zeroed for this run
  for (const auto& row : truth)
    if (row.zero && row.time_ns <= zero_time->utc_ns + static_cast<std::int64_t>(1e9))
      at_zero_nm = row.end_effector_nm;
  std::vector<double> by_instrument, by_truth, model_by_instrument, model_in_truth;
  for (std::size_t i = 0; i < data->rows; ++i) {
    const auto middle_ns = zero_time->utc_ns + static_cast<std::int64_t>(data->time_s[i] * 1e9);
    double sum = 0;
    int count = 0;
    for (const auto& row : truth)
      if (row.length && std::abs(row.time_ns - middle_ns) < static_cast<std::int64_t>(3e9))
        sum += row.end_effector_nm, ++count;
    if (count == 0)
      throw std::runtime_error("the plant's log has no row for a point of " + csv_path);
    by_instrument.push_back(1e6 * (x->values[i] - wanted->values[i]));
    by_truth.push_back(sum / count - at_zero_nm - 1e6 * wanted->values[i]);
    const double holding_nm = 1e6 * (q->values[i] - q_cmd->values[i]);
    model_by_instrument.push_back(by_instrument.back() - holding_nm);
    model_in_truth.push_back(by_truth.back() - holding_nm);
  }
  Proof proof{data->rows,
              spread(by_instrument),
              spread(by_truth),
              spread(model_by_instrument),
              spread(model_in_truth),
              0};
  if (air) {
    double low = INFINITY, high = -INFINITY;
    for (const double t : air->values) low = std::min(low, t), high = std::max(high, t);
    proof.air_change_k = high - low;
  }
  return proof;
}

std::string text(const Spread& spread) {
  char out[32];
  std::snprintf(out, sizeof out, "%.1f (%+.1f)", spread.u90_nm, spread.mean_nm);
  return out;
}

void print_proof(const std::string& folder) {
  const auto truth = read_truth(folder + "/truth.csv");
  struct Row {
    const char *label, *file;
    Proof proof;
  };
  std::vector<Row> rows = {{"without compensation (q = x)", "none", {}},
                           {"geometry only", "geometry", {}},
                           {"ten sensors", "ten", {}},
                           {"six sensors on the robot", "six", {}}};
  std::printf(
      "\nU90 (mean) in nm at new positions       where the axis came to rest         holding error "
      "taken out\n");
  std::printf("%-28s%6s%8s   %-16s%-16s  %-16s%-16s\n", "", "points", "air", "interferometer",
              "truth", "interferometer", "truth");
  for (auto& row : rows) {
    row.proof = judge(folder + "/" + row.file + ".csv", truth);
    std::printf("%-28s%6zu%6.2f K   %-16s%-16s  %-16s%-16s\n", row.label, row.proof.points,
                row.proof.air_change_k, text(row.proof.instrument).c_str(),
                text(row.proof.truth).c_str(), text(row.proof.model_by_instrument).c_str(),
                text(row.proof.model_in_truth).c_str());
  }
  const Proof &ten = rows[2].proof, &six = rows[3].proof;
  std::printf(
      "\nThe ten-sensor model learnt robot and interferometer together: by the interferometer it "
      "is right to %.1f nm, in truth to\n"
      "%.1f nm, for it teaches the robot the instrument's drift. The six-sensor model sees the "
      "robot alone: %.1f nm by the\n"
      "interferometer, %.1f nm in truth. %s\n",
      ten.model_by_instrument.u90_nm, ten.model_in_truth.u90_nm, six.model_by_instrument.u90_nm,
      six.model_in_truth.u90_nm,
      six.model_in_truth.u90_nm < ten.model_in_truth.u90_nm
          ? "That is the one to serve, though the instrument likes the other better."
          : "In this hour the instrument hardly drifted, so the two do not differ in the sense one "
            "expects.");
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string what = argc == 3 ? argv[1] : "";
  if (what == "fits") return print_fits(argv[2]), 0;
  if (what == "proof") return print_proof(argv[2]), 0;
  std::fprintf(stderr, "usage: driftwise-demo-report fits|proof FOLDER\n");
  return 2;
} catch (const std::exception& error) {
  std::fprintf(stderr, "driftwise-demo-report: %s\n", error.what());
  return 3;
}
