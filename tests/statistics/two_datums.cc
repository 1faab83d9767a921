// two_datums: what a fit over two datums costs or gains, by the plant's truth.

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "server/diagnosis/check/check_standard.h"
#include "server/formats/formula/formula.h"
#include "tests/statistics/two_datums_case.h"

namespace {

double sd_of(const driftwise::diagnosis::RunErrors& errors) {
  double sum = 0, squares = 0;
  for (const double value : errors.values) sum += value;
  const auto n = static_cast<double>(errors.values.size());
  for (const double value : errors.values) squares += (value - sum / n) * (value - sum / n);
  return std::sqrt(squares / (n - 1));
}

}  // namespace

int main(int argc, char** argv) {
  using namespace driftwise;
  using namespace driftwise::statistics;
  CLI::App app{
      "The Micro-Nano in two datums some kelvins apart: S90 in a third, by the truth, nm.\n"
      "  two_datums --first-seed 5001 --seeds 10"};
  std::uint64_t first = 1;
  int seeds = 4;
  TwoDatumsOptions options;
  std::string formula = kTwoDatumsFormula;
  app.add_option("--first-seed", first)->capture_default_str();
  app.add_option("--seeds", seeds)->check(CLI::Range(1, 10000))->capture_default_str();
  app.add_option("--room", options.room_k, "balance of the room above its start, K")
      ->capture_default_str();
  app.add_option("--pause", options.pause_h, "before a datum, h")->capture_default_str();
  app.add_option("--formula", formula)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto line = [](const char* name, const std::array<double, 3>& u90) {
    std::printf("  %-15s %7.1f %7.1f %7.1f\n", name, u90[0], u90[1], u90[2]);
  };
  try {
    for (int s = 0; s < seeds; ++s) {
      const auto made = two_datums_case(first + static_cast<std::uint64_t>(s), options);
      std::printf("seed %d: t04 %.2f %.2f %.2f degC; zeros at", static_cast<int>(first) + s,
                  made.zeros[0].values[3].value, made.zeros[1].values[3].value,
                  made.zeros[2].values[3].value);
      for (const auto& zero : {made.zeros[1], made.zeros[2]})
        std::printf(" (%.2f %.2f %.2f)", 1e3 * zero.true_pose_mm[0], 1e3 * zero.true_pose_mm[1],
                    1e3 * zero.true_pose_mm[2]);
      std::printf(" um\n");
      const auto third = third_datum_run(made);
      const auto judge = [&](const char* name, const Dataset& data, bool move) {
        calibration::FitOptions fitting;
        fitting.move_datums = move;
        const auto model = formats::fit_formula(data, formula, fitting);
        if (!model) throw std::runtime_error(model.error().message);
        line(name, u90_in_third_datum(*model, made));
        std::printf("      residual sd %.1f %.1f %.1f", 1e6 * model->outputs[0].accuracy.rmse,
                    1e6 * model->outputs[1].accuracy.rmse, 1e6 * model->outputs[2].accuracy.rmse);
        for (const auto& zero : model->datum_zeros) {
          for (const auto& [channel, at] : zero.pose)
            std::printf(", %s %.3f", channel.c_str(), 1e3 * at);
          std::printf(" %s", zero.why_not.c_str());
        }
        const auto report = diagnosis::check_model(*model, std::vector{third});
        std::printf(
            "\n      check of the third: %s; sd",
            report.verdict == diagnosis::CheckVerdict::in_control ? "in control" : "recalibrate");
        for (const auto& output : report.outputs)
          std::printf(" %.1f (%.1f)", output.points[0].sd, output.points[0].sd_limit);
        std::printf(", bias");
        for (const auto& output : report.outputs)
          std::printf(" %.1f (%.1f)", output.points[0].bias,
                      output.points[0].bias_limit.value_or(0));
        std::printf("; by a constant: sd");
        for (const auto& output : model->outputs)
          std::printf(" %.1f", sd_of(*diagnosis::run_errors(output, model->lineage.rows_calibration,
                                                            third)));
        std::printf("\n");
      };
      judge("both, constant", made.data, false);
      judge("both, moved", made.data, true);
      judge("first alone", only_datum(made.data, 1), true);
      judge("second alone", only_datum(made.data, 2), true);
      judge("truth known", at_true_zeros(made), false);
      std::fflush(stdout);
    }
    return 0;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "\n%s\n", problem.what());
    return 3;
  }
}
