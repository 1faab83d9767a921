#include "tests/integration/cell/served_model.h"

#include <iomanip>
#include <random>
#include <sstream>

namespace driftwise::tests {

std::int64_t serve_known_model(const CellAtWork& cell) {
  std::mt19937 random(20110722);
  std::normal_distribution<double> noise_mm(0, 1e-6);
  std::ostringstream csv;
  csv << std::setprecision(17) << "time_s,set,q1_mm,x_mm,t05_degC\n";
  constexpr int kRows = 81;
  for (int i = 0; i < kRows; ++i) {
    const double x_mm = -kServedLimit_mm + 0.1 * ((i * 37) % kRows);
    const double t_degc = 17 + 8.0 * i / (kRows - 1);
    const double q_mm = x_mm + kServedMmPerKelvin * (t_degc - 20) + noise_mm(random);
    csv << 10 * i << (i % 3 == 2 ? ",validation," : ",calibration,") << q_mm << ',' << x_mm << ','
        << t_degc << '\n';
  }
  const auto run = cell.ask({"data", "import", cell.write("known.csv", csv.str())}).at("id");
  const auto fit = cell.ask({"fit", "--run", std::to_string(run.get<int>()), "--model",
                             "q ~ x + t05", "--select", "all"});
  const std::int64_t model = fit.at("model_id");
  cell.say({"model", "promote", std::to_string(model), "--yes"});
  return model;
}

}  // namespace driftwise::tests
