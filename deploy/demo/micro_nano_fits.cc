#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "deploy/demo/figures.h"
#include "deploy/demo/reports.h"

namespace driftwise::demo {
namespace {

using nlohmann::json;

constexpr const char* kOutputs[] = {"q1", "q2", "q3"};

struct PublishedModel {
  const char *label, *file;
  int u90_nm[3], parameters[3];
};
// The study's table of section 6.4; outside: its full model under 3.842 N.
constexpr PublishedModel kPublished[] = {{"G", "G", {449, 572, 533}, {13, 12, 12}},
                                         {"G + F", "GF", {360, 390, 192}, {18, 21, 19}},
                                         {"G + T", "GT", {449, 173, 274}, {13, 24, 25}},
                                         {"G + T + F", "GTF", {41, 42, 49}, {22, 24, 27}}};
constexpr int kPublishedOutside[] = {164, 97, 93};

void print_row(const json& fit) {
  for (const char* output : kOutputs) {
    const auto& q = fit.at("outputs").at(output);
    std::printf("%6.1f (%2d) ", figure(q, "u90_validation_nm"), terms_in(q));
  }
  std::printf("%6.2f ms\n", figure(fit, "fit_us") / 1000);
}

void print_outside(const char* label, const json& fit, const int* published) {
  std::printf("%-12s", label);
  for (int i = 0; i < 3; ++i)
    std::printf("%4s        ", published ? std::to_string(published[i]).c_str() : "");
  std::printf(" ");
  for (const char* output : kOutputs)
    std::printf("%6.1f      ", figure(fit.at("outputs").at(output), "u90_validation_nm"));
  std::printf("\n");
}

void print_models(const std::string& folder) {
  std::printf(
      "\nS90 in nm on validation points at 0.768 N, inside the fitted forces (terms in the model)\n"
      "%-12s%-37s%-37s%9s\n%-12s%-12s%-12s%-13s%-12s%-12s%-13s\n",
      "", "published, 2011", "here", "fit", "", "q1", "q2", "q3", "q1", "q2", "q3");
  for (const auto& model : kPublished) {
    const json fit = read_json(folder + "/" + model.file + "_inside.json");
    std::printf("%-12s", model.label);
    for (int i = 0; i < 3; ++i) std::printf("%4d (%2d)   ", model.u90_nm[i], model.parameters[i]);
    std::printf(" ");
    print_row(fit);
  }
  std::printf("%-49s", "  and products of force and t04 with the pose");
  print_row(read_json(folder + "/products_inside.json"));
  print_outside("... outside", read_json(folder + "/GTF_outside.json"), kPublishedOutside);
  print_outside("  products", read_json(folder + "/products_outside.json"), nullptr);
  std::printf("%-12sunder 3.842 N, beyond the largest calibrated force of 2.305 N\n", "");
}

void print_offered(const json& offers) {
  std::printf(
      "\nmore terms, and the nm each group would add to the held-out S90 at 0.768 N (published: "
      "cross terms all rejected)\n%-40s%-28s%-28s%-28s\n",
      "", "q1", "q2", "q3");
  std::string group;
  for (const auto& offer : offers.at("offers")) {
    const auto name = offer.at("offer").get<std::string>();
    if (name != group) std::printf("%s  %-38s", group.empty() ? "" : "\n", name.c_str());
    group = name;
    const auto taken = offer.at("taken").size();
    const double change =
        figure(offer, "u90_validation_after_nm") - figure(offer, "u90_validation_before_nm");
    const double by_blocks =
        figure(offer, "u90_blocks_after_nm") - figure(offer, "u90_blocks_before_nm");
    char text[64];
    if (taken == 0)
      std::snprintf(text, sizeof text, "all rejected");
    else
      std::snprintf(text, sizeof text, "%zu in: %+.1f, blocks %+.1f", taken, change, by_blocks);
    std::printf("%-28s", text);
  }
  std::printf("\n");
}

// How far the fitted quantities moved over the campaign: what the models had to explain.
void print_conditions(const std::string& folder) {
  const auto data = read_dataset(folder + "/campaign.csv");
  const auto range = [&data](const char* symbol) {
    const auto* column = data.find(symbol);
    if (!column) return std::nan("");
    const auto [low, high] = std::ranges::minmax(column->values);
    return high - low;
  };
  std::printf(
      "%zu points in %.1f h; the robot warmed by %.2f K, its air by %.2f K; parasitic rotations "
      "span %.1f, %.1f, %.1f arcsec about x, y, z\n",
      data.rows, (data.time_s.back() - data.time_s.front()) / 3600, range("t10"), range("air_x"),
      range("rx"), range("ry"), range("rz"));
}

}  // namespace

void print_micro_nano_fits(const std::string& folder) {
  print_conditions(folder);
  print_models(folder);
  print_offered(read_json(folder + "/offers.json"));
}

}  // namespace driftwise::demo
