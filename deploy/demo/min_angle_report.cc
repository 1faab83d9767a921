#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "deploy/demo/figures.h"
#include "deploy/demo/reports.h"

namespace driftwise::demo {
namespace {

using nlohmann::json;

constexpr double kUmPerMm = 1e3, kNmPerUm = 1e3;

// A pose that was asked for, and the motor coordinates that the model answered.
struct Wanted {
  std::array<double, 3> q_mm{};
  double rx_arcsec = 0, ry_arcsec = 0, z_mm = 0;
};

std::vector<Wanted> read_wanted(const std::string& path) {
  std::istringstream file(read_file(path));
  std::vector<Wanted> all;
  std::string line;
  std::getline(file, line);  // names
  while (std::getline(file, line)) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream cells(line);
    Wanted one;
    cells >> one.q_mm[0] >> one.q_mm[1] >> one.q_mm[2] >> one.rx_arcsec >> one.ry_arcsec >>
        one.z_mm;
    if (!cells) throw std::runtime_error(path + ": found '" + line + "', expected six numbers");
    all.push_back(one);
  }
  return all;
}

// The pose of a row, by the motor coordinates that were commanded.
const Wanted& wanted_of(const std::vector<Wanted>& all, const Dataset& data, std::size_t row) {
  constexpr double kSame_mm = 1e-4;
  const auto q_mm = commanded_mm(data, row);
  for (const auto& one : all) {
    double off_mm = 0;
    for (std::size_t i = 0; i < 3; ++i) off_mm = std::max(off_mm, std::abs(one.q_mm[i] - q_mm[i]));
    if (off_mm < kSame_mm) return one;
  }
  throw std::runtime_error("a row stands at motor coordinates that nobody asked for");
}

// Wanted less measured, and wanted less true, of one coordinate of a run.
struct Judged {
  ErrorFigures instrument, truth;
  int missing = 0;  // out of the instrument's range
};

struct Coordinate {
  const char* symbol;
  const char* truth;
  double Wanted::*wanted;
  double per_truth;  // wanted's unit per truth's
  double shown;      // shown unit per wanted's
};
constexpr Coordinate kRx{"rx", "rx_arcsec", &Wanted::rx_arcsec, 1, 1};
constexpr Coordinate kRy{"ry", "ry_arcsec", &Wanted::ry_arcsec, 1, 1};
constexpr Coordinate kZ{"z", "z_nm", &Wanted::z_mm, 1e-6, kUmPerMm};

Judged judge(const std::string& folder, const std::string& run, const std::string& wanted_name,
             const Coordinate& coordinate, const TruthTable& truth) {
  const auto path = folder + "/" + run + ".csv";
  const auto data = read_dataset(path);
  const auto wanted = read_wanted(folder + "/" + wanted_name + ".wanted.csv");
  const TruthOfRun true_pose(data, path, truth);
  const auto& measured = need_column(data, coordinate.symbol).values;
  std::vector<double> by_instrument, in_truth;
  Judged out;
  for (std::size_t row = 0; row < data.rows; ++row) {
    if (is_zero_row(data, row)) continue;
    const double asked = wanted_of(wanted, data, row).*coordinate.wanted;
    if (std::isnan(measured[row]))
      ++out.missing;
    else
      by_instrument.push_back(coordinate.shown * (asked - measured[row]));
    in_truth.push_back(coordinate.shown *
                       (asked - coordinate.per_truth * true_pose.at(coordinate.truth, row)));
  }
  out.instrument = error_figures(by_instrument);
  out.truth = error_figures(in_truth);
  return out;
}

void print_judged(const char* label, const char* published, const Judged& judged) {
  std::printf("  %-12s%12s   %-26s%-26s", label, published, text(judged.instrument).c_str(),
              text(judged.truth).c_str());
  if (judged.missing > 0) std::printf("%d out of range", judged.missing);
  std::printf("\n");
}

void print_head(const char* title) {
  std::printf("\n%s\n  %-12s%12s   %-26s%-26s\n", title, "", "2011, U90", "here: instruments",
              "here: truth");
}

void print_poses(const std::string& folder, const std::string& name, const std::string& wanted,
                 const std::array<const char*, 3>& published, const TruthTable& truth) {
  print_judged("rx, arcsec", published[0], judge(folder, name + "_tilts", wanted, kRx, truth));
  print_judged("ry, arcsec", published[1], judge(folder, name + "_tilts", wanted, kRy, truth));
  print_judged("z, um", published[2], judge(folder, name + "_z", wanted, kZ, truth));
}

double coefficient(const json& output, const std::string& term, const char* key = "coefficient") {
  for (const auto& one : output.at("terms"))
    if (one.at("term") == term && one.at("in").get<bool>()) return figure(one, key);
  return 0;
}

// Measured less true motion that the model predicts, nm: the model's error by the plant.
ErrorFigures parasitic_truth(const json& output, const std::string& folder,
                             const std::string& column, bool validation, const TruthTable& truth) {
  const auto path = folder + "/parasitic.csv";
  const auto data = read_dataset(path);
  const TruthOfRun true_pose(data, path, truth);
  const auto& z = need_column(data, "z").values;
  const auto& t09 = need_column(data, "t09").values;
  std::vector<double> errors;
  for (std::size_t row = 0; row < data.rows; ++row) {
    if ((data.set[row] == PointSet::validation) != validation || is_zero_row(data, row)) continue;
    const double predicted_mm = coefficient(output, "1") + coefficient(output, "z") * z[row] +
                                coefficient(output, "z^2") * z[row] * z[row] +
                                coefficient(output, "z^3") * z[row] * z[row] * z[row] +
                                coefficient(output, "t09") * t09[row];
    errors.push_back(1e6 * predicted_mm - true_pose.at(column, row));
  }
  return error_figures(errors);
}

void print_parasitic(const std::string& folder, const TruthTable& truth) {
  struct Axis {
    const char *name, *column;
    int calibration_nm, validation_nm;
  };
  std::printf(
      "\nTable 7.3, parasitic translations, S90 in nm (truth: A90 (mean, S90))\n"
      "  %-4s%-14s%-30s%-30s\n",
      "", "", "calibration: 2011, here, truth", "  validation: 2011, here, truth");
  for (const Axis& axis : {Axis{"x", "x_nm", 390, 417}, Axis{"y", "y_nm", 293, 403}}) {
    const auto fit = read_json(folder + "/parasitic_" + axis.name + ".json");
    const auto& output = fit.at("outputs").at(axis.name);
    std::printf("  %-4s%-14s%5d %7.1f   %-22s%5d %7.1f   %s\n", axis.name,
                (std::to_string(terms_in(output)) + " terms").c_str(), axis.calibration_nm,
                figure(output, "u90_calibration_nm"),
                text(parasitic_truth(output, folder, axis.column, false, truth)).c_str(),
                axis.validation_nm, figure(output, "u90_validation_nm"),
                text(parasitic_truth(output, folder, axis.column, true, truth)).c_str());
  }
  const auto data = read_dataset(folder + "/parasitic.csv");
  const auto span = [&data](const char* symbol) {
    const auto [low, high] = std::ranges::minmax(need_column(data, symbol).values);
    return high - low;
  };
  std::printf(
      "  raw motion: x %.1f um, y %.1f um over %.1f mm of height (2011: 14, 54 um over 8 mm);"
      " t09 moved by %.2f K (2011: 1.5)\n",
      kUmPerMm * span("x"), kUmPerMm * span("y"), span("z"), span("t09"));
}

// The fit of the large formula on the fine poses, with the study's probe and with an ideal one.
void print_probe(const std::string& folder) {
  const auto probe = read_json(folder + "/model2.json");
  const auto ideal = read_json(folder + "/ideal/model2.json");
  std::printf(
      "\nThe probe limits the fine model: S90 in nm on the 216 poses between those fitted\n"
      "  %-34s%10s%10s%10s\n",
      "", "q1", "q2", "q3");
  const auto row = [](const char* label, const json& fit) {
    std::printf("  %-34s", label);
    for (const char* q : {"q1", "q2", "q3"})
      std::printf("%10.0f", figure(fit.at("outputs").at(q), "u90_validation_nm"));
    std::printf("\n");
  };
  row("probe with hysteresis", probe);
  row("ideal probe, same robot and day", ideal);
}

}  // namespace

void print_min_angle_rectification(const std::string& folder) {
  const auto fit = read_json(folder + "/rectification.json");
  const auto& z = fit.at("outputs").at("z");
  const double k = coefficient(z, "touch");
  std::printf(
      "z = k z_probe + c on %d points: k = %.6f, u = %.6f; c = %+.2f um, u = %.2f um (it is the "
      "zeros' and goes with them)\nwhat the probe misses afterwards: S90 %.2f um, its hysteresis "
      "(published: 1 to 2 um)\n",
      fit.at("rows").at("calibration").get<int>(), k,
      coefficient(z, "touch", "standard_error_serial"), kUmPerMm * coefficient(z, "1"),
      kUmPerMm * coefficient(z, "1", "standard_error_serial"),
      figure(z, "u90_calibration_nm") / kNmPerUm);
  std::ofstream scale(folder + "/scale.txt");
  char number[32];
  std::snprintf(number, sizeof number, "%.6f", k);
  scale << number << "\n";
  if (!scale) throw std::runtime_error(folder + "/scale.txt cannot be written");
}

void print_min_angle_tables(const std::string& folder) {
  const TruthTable truth(folder + "/truth.csv");
  std::printf("\nA90 (mean, S90): wanted less measured, wanted less true\n");
  print_head("Table 7.1, large stroke: 25 tilts up to 3 degrees at height 0, moved by model 1");
  print_poses(folder, "large_check", "large_check", {"200", "200", "5"}, truth);
  std::printf(
      "  (the inclinometer counts 36 arcsec and the tilts asked for are whole counts; it shows how "
      "far an axis rises, which is less than rx while ry is large)\n");
  print_head("Fine poses as model 1 meets them: 343 and 216 within 300 arcsec and 3 mm");
  print_poses(folder, "fine", "fine", {"", "", ""}, truth);
  print_head("Table 7.2, fine stroke: 216 poses within 250 arcsec and 2.5 mm, moved by model 2");
  print_poses(folder, "fine_check", "fine_check", {"5", "11", "1.1"}, truth);
  print_parasitic(folder, truth);
  print_probe(folder);
  std::printf("\nTables 7.4 and 7.5 are the Micro-Nano's: deploy/demo.sh indentation.\n");
}

}  // namespace driftwise::demo
