// foreign_accept: what accepting the findings does to the served target, on the independent
// population, judged at the generator's truth.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <set>

#include "tests/hidden_effects/accepting/foreign_case.h"
#include "tests/hidden_effects/accepting/foreign_report.h"

namespace {

using namespace driftwise::hidden;

std::vector<ForeignCase> recorded(const std::string& path) {
  std::vector<ForeignCase> cases;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) cases.push_back(case_of_line(line));
  return cases;
}

}  // namespace

int main(int argc, char** argv) try {
  std::uint64_t seed_base = 3'500'000;
  int rounds = 4, nulls = 199, most_accepted = 0, one_number = -1;
  double minutes = 0;
  std::string out;
  bool only_report = false;
  CLI::App app{
      "What accepting does to the served target, at the truth.\n\nforeign_accept --out "
      "/tmp/accept.jsonl "
      "--accepted 200\n\nOne line of JSON per data set in --out; numbers that are there are not "
      "done "
      "again. The summary goes to standard output."};
  app.add_option("--out", out, "results, one line of JSON each; standard output without it");
  app.add_option("--seed-base", seed_base, "seed of number 0")->capture_default_str();
  app.add_option("--rounds", rounds, "times 276 data sets")->check(CLI::Range(1, 100));
  app.add_option("--accepted", most_accepted, "end after so many with something accepted; 0: none");
  app.add_option("--minutes", minutes, "start no data set after so long; 0: no limit");
  app.add_option("--number", one_number, "this number only");
  app.add_option("--nulls", nulls, "series of noise of the diagnosis")->capture_default_str();
  app.add_flag("--report", only_report, "only the summary of what is in --out");
  CLI11_PARSE(app, argc, argv);

  auto cases = out.empty() ? std::vector<ForeignCase>() : recorded(out);
  std::set<int> done;
  int accepted = 0;
  for (const auto& one : cases) {
    done.insert(one.number);
    accepted += one.is_accepted() ? 1 : 0;
  }
  const auto begin = std::chrono::steady_clock::now();
  for (const auto& ordered : paired_orders(seed_base, rounds)) {
    const std::chrono::duration<double> past = std::chrono::steady_clock::now() - begin;
    if (only_report || (most_accepted > 0 && accepted >= most_accepted) ||
        (minutes > 0 && past.count() > 60 * minutes))
      break;
    if (done.contains(ordered.number) || (one_number >= 0 && ordered.number != one_number))
      continue;
    cases.push_back(judged_case(ordered, nulls));
    accepted += cases.back().is_accepted() ? 1 : 0;
    const auto line = json_line(cases.back());
    if (out.empty()) {
      std::printf("%s\n", line.c_str());
      continue;
    }
    std::ofstream file(out, std::ios::app);
    if (!(file << line << '\n' << std::flush)) {
      std::fprintf(stderr, "%s: the result of number %d could not be written\n", out.c_str(),
                   ordered.number);
      return 5;
    }
  }
  std::printf("%s", accepting_report(cases).c_str());
  return 0;
} catch (const std::runtime_error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 5;
}
