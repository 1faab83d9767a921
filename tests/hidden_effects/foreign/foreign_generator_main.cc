// foreign_generator: data sets of an independent population, with their key.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/hidden_effects/foreign/dataset.h"

int main(int argc, char** argv) {
  namespace foreign = driftwise::foreign;
  foreign::Order order;
  std::uint64_t first = 1;
  int count = 1;
  std::string out = ".";
  bool list = false;
  CLI::App app{
      "Data sets of an independent population.\n\nforeign_generator --first-seed 1 --count 20 "
      "--kind single "
      "--chi2 150 --out /tmp/foreign\n\nWrites KIND_SEED.csv each and one line each in key.jsonl."};
  app.add_option("--first-seed", first, "first seed");
  app.add_option("--count", count, "number of data sets");
  app.add_option("--kind", order.kind, "null, single, pair, unlisted")
      ->check(CLI::IsMember({"null", "single", "pair", "unlisted"}));
  app.add_option("--cause", order.cause, "catalogue id or unlisted id; by the seed if absent");
  app.add_option("--chi2", order.chi2, "strength over the calibration rows")
      ->check(CLI::PositiveNumber);
  app.add_option("--vary", order.vary, "all, none, robot, plan, noise, sensors, units, cycle")
      ->check(
          CLI::IsMember({"all", "none", "robot", "plan", "noise", "sensors", "units", "cycle"}));
  app.add_option("--plan", order.plan, "kind of plan");
  app.add_option("--robot", order.robot, "kind of robot");
  app.add_option("--noise", order.noise, "kind of noise");
  app.add_option("--units", order.units, "study, random, auto")
      ->check(CLI::IsMember({"study", "random", "auto"}));
  app.add_flag("--reserved", order.reserved, "plans and robots kept for the full count");
  app.add_option("--out", out, "directory; made if absent");
  app.add_flag("--list", list, "print causes, unlisted effects, plans, robots and noises");
  CLI11_PARSE(app, argc, argv);
  if (list) {
    const auto print = [](const char* title, const std::vector<std::string>& items) {
      for (const std::string& item : items) {
        std::printf("%s %s\n", title, item.c_str());
      }
    };
    print("cause", foreign::cause_ids());
    print("unlisted", foreign::unlisted_ids());
    print("plan", foreign::open_plans());
    print("reserved_plan", foreign::reserved_plans());
    print("robot", foreign::open_robots());
    print("reserved_robot", foreign::reserved_robots());
    print("noise", foreign::noise_kinds());
    return 0;
  }
  std::filesystem::create_directories(out);
  std::ofstream key(std::filesystem::path(out) / "key.jsonl", std::ios::app);
  int refused = 0;
  for (int k = 0; k < count; ++k) {
    order.seed = first + static_cast<std::uint64_t>(k);
    try {
      const foreign::Generated made = foreign::generate(order);
      const foreign::Dress dress = foreign::dress_of(made);
      const std::string file =
          order.kind + "_" + std::to_string(order.seed) + "_" + dress.kind + ".csv";
      std::ofstream(std::filesystem::path(out) / file) << foreign::dataset_csv(made, dress);
      key << foreign::key_json(made, dress, file) << '\n' << std::flush;
    } catch (const std::exception& error) {
      ++refused;
      std::fprintf(stderr, "%s\n", error.what());
    }
  }
  if (!key) {
    std::fprintf(stderr, "%s: the key could not be written\n", out.c_str());
    return 5;
  }
  return refused == count ? 5 : 0;
}
