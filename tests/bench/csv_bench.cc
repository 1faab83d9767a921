// Reading large datasets against the fastest number parser of Debian 12, fast_float, on the same
// mapped file in one run.
//
//   csv_bench make FILE [rows] [columns]   writes a dataset: time, motor, pose on a grid,
//   temperatures csv_bench FILE [rounds] [threads]      every field once with fast_float; the
//   reader csv_bench parse FILE                   the former alone, as a process of its own: the
//   reference of
//                                          `driftwise fit FILE`

#include <fast_float/fast_float.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "server/calibration/fit.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/formula/formula.h"
#include "server/threads/threaded_executor.h"

namespace {

using namespace driftwise;
constexpr const char* kFormula = "q1 ~ poly(x, 3) + T";

using Clock = std::chrono::steady_clock;

// A campaign in which every number has the digits its instrument gives: 14 to 17 as a filter
// leaves them.
void make(const std::string& path, int rows, int columns) {
  std::mt19937_64 random(20110722);
  std::normal_distribution<double> normal;
  std::ofstream file(path, std::ios::binary);
  std::string text = "# driftwise-dataset: 1\ntime_s,q1_mm,x_mm";
  const int temperatures = columns - 3;
  for (int k = 1; k <= temperatures; ++k)
    text += ",t" + std::string(k < 10 ? "0" : "") + std::to_string(k) + "_degC";
  std::vector<double> wander(static_cast<std::size_t>(temperatures));
  const auto put = [&text](double value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    text.append(digits, static_cast<std::size_t>(end - digits));
  };
  for (int row = 0; row < rows; ++row) {
    const double time_s = 14.3 * row, x = -4 + 0.5 * (row % 17) + 1e-5 * normal(random);
    double q = 1.0001 * x + 2e-5 * x * x;
    text += '\n';
    put(time_s);
    std::vector<double> t(wander.size());
    for (std::size_t k = 0; k < t.size(); ++k) {
      wander[k] = 0.98 * wander[k] + 0.01 * normal(random);
      t[k] = 21 + 0.5 * std::sin(time_s / (2000.0 + 700.0 * static_cast<double>(k))) + wander[k];
      q += (k % 3 == 0 ? 4e-4 : 0) * (t[k] - 21);
    }
    text += ',';
    put(q + 3e-6 * normal(random));
    text += ',';
    put(x);
    for (const double one : t) {
      text += ',';
      put(one);
    }
    if (text.size() > (1u << 22)) {
      file << text;
      text.clear();
    }
  }
  file << text << '\n';
}

std::string_view map_file(const char* path) {
  const int file = ::open(path, O_RDONLY);
  struct stat about {};
  if (file < 0 || ::fstat(file, &about) != 0) {
    std::perror(path);
    std::exit(1);
  }
  const auto size = static_cast<std::size_t>(about.st_size);
  return {static_cast<const char*>(::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0)), size};
}

// Every field of the rows once, into one number, so that nothing is left out.
double parse_rows(std::string_view text) {
  const char *at = text.data(), *end = at + text.size();
  double sum = 0;
  while (at < end) {
    double value = 0;
    at = fast_float::from_chars(at, end, value).ptr + 1;
    sum += value;
  }
  return sum;
}

std::string_view rows_of(std::string_view text) {
  while (text.starts_with('#')) text.remove_prefix(text.find('\n') + 1);
  text.remove_prefix(text.find('\n') + 1);
  return text;
}

double seconds_of(const std::function<double()>& work) {
  const auto start = Clock::now();
  volatile double kept = work();
  (void)kept;
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// The same, the rows cut into as many pieces as there are threads.
double parse_fields_on(std::string_view text, int threads, const calibration::Executor& executor) {
  const auto line_after = [&](std::size_t at) {
    return at == 0 ? 0 : std::min(text.find('\n', at), text.size() - 1) + 1;
  };
  std::vector<double> sums(static_cast<std::size_t>(threads));
  calibration::run_on(executor, sums.size(), [&](std::size_t i) {
    const std::size_t begin = line_after(text.size() * i / sums.size());
    const std::size_t end = line_after(text.size() * (i + 1) / sums.size());
    sums[i] = parse_rows(text.substr(begin, end - begin));
  });
  double sum = 0;
  for (const double one : sums) sum += one;
  return sum;
}

// What `driftwise fit FILE` does between opening the file and printing: every temperature offered,
// ten held-out blocks, all statistics.
double fit(std::string_view text, const std::string& name, const calibration::Executor& executor) {
  const auto data = formats::read_dataset_csv(text, name, executor);
  const auto formula = formats::Formula::parse(kFormula);
  calibration::FitOptions options;
  options.executor = executor;
  options.candidates = formula->expand(*data).value();
  const auto model = calibration::fit(*data, options);
  if (!model) {
    std::fprintf(stderr, "%s\n", model.error().message.c_str());
    std::exit(1);
  }
  return model->outputs[0].accuracy.rmse;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  if (first == "make" && argc > 2) {
    make(argv[2], argc > 3 ? std::atoi(argv[3]) : 1000000, argc > 4 ? std::atoi(argv[4]) : 40);
    return 0;
  }
  if (first == "parse" && argc > 2) {
    std::printf("%g\n", parse_rows(rows_of(map_file(argv[2]))));
    return 0;
  }
  if (argc < 2) return std::fprintf(stderr, "csv_bench make FILE | FILE | parse FILE\n"), 2;
  const std::string_view text = map_file(argv[1]);
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 5;
  const int threads = argc > 3 ? std::atoi(argv[3]) : threads::processors();
  const auto executor = threads::threaded_executor(threads);
  std::vector<double> floor, floor_on, reader, reader_on, fit_on;
  const auto read = [&](const calibration::Executor& on) {
    const auto data = formats::read_dataset_csv(text, argv[1], on);
    return data ? data->columns.back().values.back() : std::nan("");
  };
  for (int round = 0; round <= rounds; ++round) {
    if (round == 1)
      floor.clear(), floor_on.clear(), reader.clear(), reader_on.clear(), fit_on.clear();
    floor.push_back(seconds_of([&] { return parse_rows(rows_of(text)); }));
    reader.push_back(seconds_of([&] { return read({}); }));
    floor_on.push_back(
        seconds_of([&] { return parse_fields_on(rows_of(text), threads, executor); }));
    reader_on.push_back(seconds_of([&] { return read(executor); }));
    fit_on.push_back(seconds_of([&] { return fit(text, argv[1], executor); }));
  }
  std::printf("%.0f MB: every field once with fast_float %.3f s on 1 thread, %.3f s on %d\n",
              1e-6 * static_cast<double>(text.size()), median(floor), median(floor_on), threads);
  std::printf("read_dataset_csv on 1 thread %.3f s, %.2f x; on %d %.3f s, %.2f x\n", median(reader),
              median(reader) / median(floor), threads, median(reader_on),
              median(reader_on) / median(floor_on));
  const double ratio = median(fit_on) / median(floor), strict = median(fit_on) / median(floor_on);
  std::printf(
      "fit \"%s\" on %d threads %.3f s, %.2f x the parser on 1 thread, %.2f x on %d; goal 2: %s\n",
      kFormula, threads, median(fit_on), ratio, strict, threads,
      strict <= 2  ? "met"
      : ratio <= 2 ? "met against 1 thread"
                   : "NOT MET");
}
