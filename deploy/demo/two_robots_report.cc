#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "deploy/demo/figures.h"
#include "deploy/demo/reports.h"

namespace driftwise::demo {
namespace {

using nlohmann::json;

constexpr const char* kLengths[] = {"x", "y", "z"};
constexpr const char* kAngles[] = {"rx", "ry", "rz"};

// Value of a term such as "mn.x^2:mn.y" in a row; "1" of the constant.
double term_value(const std::string& term, const Dataset& data, std::size_t row) {
  if (term == "1") return 1;
  double value = 1;
  std::istringstream factors(term);
  for (std::string factor; std::getline(factors, factor, ':');) {
    const auto caret = factor.find('^');
    const int power = caret == std::string::npos ? 1 : std::stoi(factor.substr(caret + 1));
    value *= std::pow(need_column(data, factor.substr(0, caret)).values[row], power);
  }
  return value;
}

// Model less truth on the validation rows, both from the first return to zero on.
ErrorFigures rotation_in_truth(const std::string& folder, const std::string& angle,
                               const json& output, const TruthTable& truth) {
  const auto path = folder + "/tool.csv";
  const auto data = read_dataset(path);
  const TruthOfRun true_pose(data, path, truth);
  std::vector<double> errors;
  double offset = std::nan("");
  for (std::size_t row = 0; row < data.rows; ++row) {
    double predicted = 0;
    for (const auto& one : output.at("terms"))
      if (one.at("in").get<bool>())
        predicted += figure(one, "coefficient") * term_value(one.at("term"), data, row);
    if (is_zero_row(data, row) && std::isnan(offset)) offset = predicted;
    if (data.set[row] != PointSet::validation || is_zero_row(data, row)) continue;
    errors.push_back(predicted - offset - true_pose.at(angle + "_arcsec", row));
  }
  return error_figures(errors);
}

using ToolPlace = std::array<double, 3>;
std::vector<ToolPlace> wanted_poses(const std::string& path) {
  std::istringstream file(read_file(path));
  std::vector<ToolPlace> all;
  std::string line;
  std::getline(file, line);  // names
  while (std::getline(file, line)) {
    for (char& c : line)
      if (c == ',') c = ' ';
    std::istringstream cells(line);
    ToolPlace one{};
    cells >> one[0] >> one[1] >> one[2];
    if (!cells) throw std::runtime_error(path + ": found '" + line + "', expected three numbers");
    all.push_back(one);
  }
  return all;
}

// ToolPlace less true, nm: since the lengths were zeroed for the run.
std::array<ErrorFigures, 3> places_in_truth(const std::string& folder, const std::string& run,
                                            const TruthTable& truth) {
  const auto path = folder + "/" + run + ".csv";
  const auto data = read_dataset(path);
  const auto wanted = wanted_poses(folder + "/wanted.csv");
  const auto zero_ns = time_zero_ns(data, path);
  constexpr double kNmOfMm = 1e6;
  std::array<std::vector<double>, 3> errors;
  for (std::size_t row = 0; row < data.rows; ++row) {
    if (is_zero_row(data, row)) continue;
    const auto place = static_cast<std::size_t>(data.line[row]) - 1;
    if (place >= wanted.size()) throw std::runtime_error(path + ": a line that is no position");
    const auto middle_ns = zero_ns + static_cast<std::int64_t>(data.time_s[row] * 1e9);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string column = std::string(kLengths[k]) + "_nm";
      const double at_zero = truth.at_zero(column, zero_ns + 1'000'000'000);
      errors[k].push_back(
          kNmOfMm * wanted[place][k] -
          (truth.mean_at_rest(column, middle_ns, commanded_mm(data, row)) - at_zero));
    }
  }
  return {error_figures(errors[0]), error_figures(errors[1]), error_figures(errors[2])};
}

// Places of each contact at its largest force, um, from truth.csv: of the end-effector on the
// substrate and of the tip in the room.
struct ContactPlace {
  double force_n = 0;
  std::array<double, 2> on_substrate_um{}, tip_um{};
};
// Whether a touch belongs to the contact before: a graze in the noise, half a step below the
// contact, may part once more. Another contact is 20 um away at least.
bool is_same_place(const ContactPlace& before, const ContactPlace& now) {
  constexpr double kSame_um = 5;
  return std::hypot(now.on_substrate_um[0] - before.on_substrate_um[0],
                    now.on_substrate_um[1] - before.on_substrate_um[1]) < kSame_um;
}

std::vector<ContactPlace> contacts_in_truth(const std::string& path) {
  std::istringstream file(read_file(path));
  std::map<std::string, std::size_t> columns;
  std::vector<ContactPlace> all;
  bool touching = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("#")) continue;
    std::vector<std::string> cells;
    std::istringstream fields(line);
    for (std::string cell; std::getline(fields, cell, ',');) cells.push_back(cell);
    if (columns.empty()) {
      for (std::size_t i = 0; i < cells.size(); ++i) columns[cells[i]] = i;
      continue;
    }
    const auto value = [&](const std::string& name) {
      return std::stod(cells.at(columns.at(name)));
    };
    const double force_n = value("contact_N");
    const ContactPlace now = {
        force_n,
        {1e-3 * (value("x_nm") - value("ma_x_nm")), 1e-3 * (value("y_nm") - value("ma_y_nm"))},
        {1e-3 * value("tip_x_nm"), 1e-3 * value("tip_y_nm")}};
    if (force_n > 0 && !touching && (all.empty() || !is_same_place(all.back(), now)))
      all.emplace_back();
    touching = force_n > 0;
    if (touching && force_n >= all.back().force_n) all.back() = now;
  }
  return all;
}

}  // namespace

void print_two_robots_contacts(const std::string& folder) {
  const auto record = read_json(folder + "/indentation.toml.state.json");
  const auto contacts = contacts_in_truth(folder + "/truth.csv");
  const auto place = [&](const json& touch) {
    return contacts.at(touch.at("contact").get<std::size_t>() - 1);
  };
  const auto zero = place(record.at("zero").at("touch"));
  double squares = 0, largest = 0;
  int open = 0;
  std::printf("true place less wanted, um: end-effector on the substrate, tip in the room\n");
  for (const auto& indent : record.at("indents")) {
    const std::size_t axis = indent.at("line") == "x" ? 0 : 1;
    const double at_um = indent.at("at_um");
    const auto here = place(indent.at("touch"));
    const double error = here.on_substrate_um[axis] - zero.on_substrate_um[axis] - at_um;
    const bool closed = indent.at("closed_loop");
    std::printf("  %-6s%+9.3f%+9.3f%s\n", indent.at("id").get<std::string>().c_str(), error,
                here.tip_um[axis] - zero.tip_um[axis] - at_um, closed ? "  closed loop" : "");
    if (closed) continue;
    squares += error * error;
    largest = std::max(largest, std::abs(error));
    ++open;
  }
  if (open > 0)
    std::printf("open loop, end-effector on the substrate: rms %.3f um, at most %.3f um\n",
                std::sqrt(squares / open), largest);
}

void print_two_robots_tables(const std::string& folder) {
  const TruthTable truth(folder + "/truth.csv");
  const auto model = read_json(folder + "/tool-model.json");
  const auto verification = read_json(folder + "/by_plan.verify.json");
  const auto by_plan = places_in_truth(folder, "by_plan", truth);
  const auto by_geometry = places_in_truth(folder, "by_geometry", truth);
  constexpr int kPose_nm[] = {58, 75, 62};
  std::printf(
      "\nTable 7.4, the Micro-Nano moved by its model, A90 (mean, S90) in nm: wanted less "
      "measured, "
      "wanted less true\n  %-4s%10s   %-26s%-26s%-26s\n",
      "", "2011, U90", "here: instruments", "here: truth", "truth, nominal geometry");
  for (std::size_t k = 0; k < 3; ++k)
    std::printf("  %-4s%10d   %-26s%-26s%-26s\n", kLengths[k], kPose_nm[k],
                text(by_instrument(verification, std::string("mn.") + kLengths[k]).all).c_str(),
                text(by_plan[k]).c_str(), text(by_geometry[k]).c_str());
  std::printf("  motor coordinates on the positions between those fitted, S90:");
  for (const char* q : {"mn.q1", "mn.q2", "mn.q3"})
    std::printf(" %.0f", figure(model.at("outputs").at(q), "u90_validation_nm"));
  std::printf(" nm (2011: 41, 42, 49, the digits of case B)\n");

  constexpr double kRotation_arcsec[] = {0.5, 1.2, 0.4};
  constexpr int kTerms[] = {11, 13, 10};
  std::printf("\nTable 7.5, its parasitic rotations by a model, arcsec\n  %-4s%20s%26s%20s   %s\n",
              "", "2011, U90 (terms)", "here, S90 fitted, between", "terms",
              "truth: A90 (mean, S90)");
  for (std::size_t k = 0; k < 3; ++k) {
    const auto fit = read_json(folder + "/tool-" + kAngles[k] + ".json");
    const auto& output = fit.at("outputs").at(std::string("mn.") + kAngles[k]);
    const auto in_truth = rotation_in_truth(folder, kAngles[k], output, truth);
    std::printf("  %-4s%15.1f (%d)%18.2f, %.2f%24d   %.2f (%+.2f, %.2f)\n", kAngles[k],
                kRotation_arcsec[k], kTerms[k], figure(output, "u90_calibration_arcsec"),
                figure(output, "u90_validation_arcsec"), terms_in(output), in_truth.a90,
                in_truth.mean, in_truth.u90);
  }
}

}  // namespace driftwise::demo
