// The fit's arithmetic against its floor in one run: OpenBLAS's SYRK of the same matrix, rows split
// over the same threads. Every figure is the median over rounds in which all take their turn.
//
//   fit_floor_bench [rounds] [threads]
//
// Measured per size: triangle, selection and solution of a prepared design (its columns are made
// from the data inside that time), by X'X and by QR; and the memory of it, as the process's peak
// beside the matrix, which here are the data's own columns.

#include <cblas.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/calibration/design/design.h"
#include "server/calibration/linear/row_reduction.h"
#include "server/calibration/linear/solution.h"
#include "server/calibration/selection/stepwise.h"
#include "server/threads/threaded_executor.h"
#include "tests/bench/fit_problems.h"

namespace {

using namespace driftwise;
using namespace driftwise::calibration;
using Clock = std::chrono::steady_clock;
using Eigen::Index;

double ms_of(const std::function<void()>& work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// VmHWM or VmRSS, in bytes.
double memory(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(key + ":"))
      return 1024 * std::strtod(line.c_str() + key.size() + 1, nullptr);
  return 0;
}

void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

double solve_prepared(const Design& design, Solver solver, const Executor& executor) {
  double sum = 0;
  const Triangle triangle = RowReduction(design, {0, design.row_count()}, solver, executor).all();
  for (Index o = 0; o < static_cast<Index>(design.outputs.size()); ++o) {
    const Selection selection = select(triangle, design.basis, design.always, o, {});
    sum += solve(triangle, design.basis, selection.set.order(), o).coefficients.sum();
  }
  return sum;
}

void syrk(const Eigen::MatrixXd& matrix, int threads, const Executor& executor) {
  const Index width = matrix.cols();
  std::vector<Eigen::MatrixXd> parts(static_cast<std::size_t>(threads),
                                     Eigen::MatrixXd(width, width));
  run_on(executor, parts.size(), [&](std::size_t i) {
    const Index begin = matrix.rows() * static_cast<Index>(i) / threads,
                end = matrix.rows() * static_cast<Index>(i + 1) / threads;
    cblas_dsyrk(CblasColMajor, CblasLower, CblasTrans, static_cast<int>(width),
                static_cast<int>(end - begin), 1, matrix.data() + begin,
                static_cast<int>(matrix.rows()), 0, parts[i].data(), static_cast<int>(width));
  });
  for (std::size_t i = 1; i < parts.size(); ++i) parts[0] += parts[i];
}

const char* verdict(bool met) { return met ? "met" : "NOT MET"; }

// repeat: short work is timed several times over.
struct Medians {
  double floor, gram, qr;
};
Medians measure(const Design& design, int rounds, int repeat, int threads,
                const Executor& executor) {
  const Eigen::MatrixXd matrix = design.block(0, design.row_count());
  std::vector<double> floor, gram, qr;
  const auto timed = [&](std::vector<double>& into, const std::function<void()>& work) {
    into.push_back(ms_of([&] {
                     for (int i = 0; i < repeat; ++i) work();
                   }) /
                   repeat);
  };
  for (int round = 0; round <= rounds; ++round) {
    if (round == 1) floor.clear(), gram.clear(), qr.clear();  // the first warms up
    timed(floor, [&] { syrk(matrix, threads, executor); });
    timed(gram, [&] { solve_prepared(design, Solver::gram, executor); });
    timed(qr, [&] { solve_prepared(design, Solver::qr, executor); });
  }
  return {median(floor), median(gram), median(qr)};
}

void small(const char* name, const bench::Problem& problem, double goal_us, int rounds) {
  const auto design = make_design(problem.data, problem.options);
  const Medians m = measure(*design, rounds, 50, 1, {});
  std::printf("%-12s floor %8.1f us  qr (the one taken) %8.1f us, %.1f x; goal %.0f us: %s\n", name,
              1e3 * m.floor, 1e3 * m.qr, m.qr / m.floor, goal_us, verdict(1e3 * m.qr <= goal_us));
}

void large(int rows, int columns, int rounds, int threads, const Executor& executor) {
  const double before = memory("VmRSS");
  const auto problem = std::make_unique<bench::Problem>(bench::many_rows(rows, columns));
  const double matrix = 8.0 * rows * (columns + 1);
  forget_peak();
  const auto design = make_design(problem->data, problem->options);
  solve_prepared(*design, Solver::automatic, executor);
  const double peak = memory("VmHWM") - before;
  const Medians m = measure(*design, rounds, 1, threads, executor);
  std::printf("%dx%d  floor %7.2f ms, %d threads, %.0f Gflop/s\n", rows, columns, m.floor, threads,
              1e-6 * rows * columns * columns / m.floor);
  std::printf("  gram   %7.2f ms, %.2f x the floor; goal 1.4: %s\n", m.gram, m.gram / m.floor,
              verdict(m.gram <= 1.4 * m.floor));
  std::printf("  qr     %7.2f ms, %.2f x the floor; goal 5: %s\n", m.qr, m.qr / m.floor,
              verdict(m.qr <= 5 * m.floor));
  std::printf("  memory %7.1f MB, %.2f x the matrix; goal 1.3: %s\n", peak / 1e6, peak / matrix,
              verdict(peak <= 1.3 * matrix));
}

void growth(int rounds, const Executor& executor) {
  double last = 0;
  std::printf("growth with rows, 40 columns, gram:");
  for (const int rows : {50000, 100000, 200000, 400000}) {
    const bench::Problem problem = bench::many_rows(rows, 40);
    const auto design = make_design(problem.data, problem.options);
    std::vector<double> times;
    for (int round = 0; round <= rounds; ++round)
      times.push_back(ms_of([&] { solve_prepared(*design, Solver::gram, executor); }));
    const double now = median(times);
    std::printf(" %d: %.2f ms%s", rows, now,
                last > 0 ? (" (x " + std::to_string(now / last).substr(0, 4) + ")").c_str() : "");
    last = now;
  }
  std::printf("; twice the rows, twice the time\n");
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 7;
  const int threads = argc > 2 ? std::atoi(argv[2]) : threads::processors();
  openblas_set_num_threads(1);  // its own threads do not split a tall matrix
  const Executor executor = threads::threaded_executor(threads);
  small("560x12", bench::case_a(), 50, rounds);
  small("756x29x3", bench::case_b(), 400, rounds);
  large(100000, 60, rounds, threads, executor);
  large(1000000, 100, std::min(rounds, 5), threads, executor);
  growth(rounds, executor);
}
