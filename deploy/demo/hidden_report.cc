// Table of the hidden causes beside the findings of the diagnosis.

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "deploy/demo/figures.h"
#include "deploy/demo/reports.h"

namespace driftwise::demo {
namespace {

using nlohmann::json;

bool names(const json& finding, const std::string& cause) {
  if (finding.value("cause", "") == cause) return true;
  const auto& others = finding.value("indistinguishable_from", json::array());
  return std::any_of(others.begin(), others.end(), [&](const json& other) {
    return other.get<std::string>().starts_with(cause);
  });
}

std::string size_of(const json& hidden) {
  char size[64];
  std::snprintf(size, sizeof size, "%.4g %s", hidden.at("size").get<double>(),
                hidden.at("unit").get<std::string>().c_str());
  return size;
}

}  // namespace

bool print_hidden(const std::string& folder) {
  const json answer = read_json(folder + "/sealed.json");
  const json diagnosis = read_json(folder + "/diagnosis.json");
  const json findings = diagnosis.value("findings", json::array());
  std::printf("the sealed answer                     what the diagnosis said\n");
  bool all = true;
  for (const auto& hidden : answer.at("hidden")) {
    const auto cause = hidden.at("cause").get<std::string>();
    const auto found = std::find_if(findings.begin(), findings.end(),
                                    [&](const json& one) { return names(one, cause); });
    const std::string what =
        cause + ", " + hidden.at("symbol").get<std::string>() + ", " + size_of(hidden);
    all = all && found != findings.end();
    std::printf("%-37s %s\n", what.c_str(),
                found == findings.end() ? "NOT FOUND"
                                        : ("found: " + found->value("sentence", "") +
                                           (found->value("cause", "") == cause
                                                ? ""
                                                : " (among those that these data do not separate)"))
                                              .c_str());
  }
  for (const auto& finding : findings) {
    const auto& hidden = answer.at("hidden");
    if (std::none_of(hidden.begin(), hidden.end(), [&](const json& one) {
          return names(finding, one.at("cause").get<std::string>());
        }))
      std::printf("%-37s also named: %s\n", "-", finding.value("sentence", "").c_str());
  }
  return all;
}

}  // namespace driftwise::demo
