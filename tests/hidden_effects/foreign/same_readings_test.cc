// The same readings in other units and under other names: the same answer to the last finding.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "server/diagnosis/diagnose.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/formula/formula.h"
#include "tests/hidden_effects/foreign/dataset.h"
#include "tests/hidden_effects/foreign/generate.h"

namespace driftwise::foreign {
namespace {

constexpr std::uint64_t kFirstSeed = 2700000;
constexpr int kSeeds = 20;

struct Told {
  std::string verdict;
  // "cause subject", in the study's names, with the parameters that no unit of a file scales.
  std::map<std::string, std::map<std::string, double>> findings;
  std::vector<std::string> not_testable;
};

Told told(const Generated& made) {
  const Dress dress = dress_of(made);
  const auto data = formats::read_dataset_csv(dataset_csv(made, dress), "foreign.csv");
  if (!data) throw std::runtime_error(data.error().message);
  diagnosis::DiagnoseOptions options;
  options.baseline = *formats::Formula::parse(baseline_formula(made, dress))->expand(*data);
  options.nulls = 49;
  const auto found = diagnosis::diagnose(*data, options);
  if (!found) throw std::runtime_error(found.error().message);
  std::map<std::string, std::string> study;  // of each name in the file
  for (int k = 0; k < made.campaign.thermometer_count(); ++k) {
    study[dress.symbol_of(thermometer_symbol(k))] = thermometer_symbol(k);
  }
  study[dress.symbol_of("activity")] = "activity";
  Told result{std::string(diagnosis::to_string(found->verdict)), {}, {}};
  for (const auto& finding : found->findings) {
    const auto name = study.find(finding.subject);
    auto& parameters =
        result
            .findings[finding.cause + " " + (name == study.end() ? finding.subject : name->second)];
    for (const auto& parameter : finding.parameters)
      for (const char* kept : {"tau_s", "period_nm", "period_s", "width_nm", "time_s"})
        if (parameter.name == kept) parameters[kept] = parameter.value;
  }
  for (const auto& one : found->not_testable) result.not_testable.push_back(one.cause);
  return result;
}

TEST(SameReadings, InOtherUnitsAndUnderOtherNamesGiveTheSameFindings) {
  const std::vector<std::string> kinds = {"null", "single", "pair", "single"};
  int with_findings = 0;
  for (int i = 0; i < kSeeds; ++i) {
    Order order;
    order.seed = kFirstSeed + static_cast<std::uint64_t>(i);
    order.kind = kinds[static_cast<std::size_t>(i) % kinds.size()];
    order.units = "study";
    Generated made;
    try {
      made = generate(order);
    } catch (const std::runtime_error&) {
      continue;  // no machine gives this strength
    }
    const Told study = told(made);
    made.order.units = "random";
    const Told other = told(made);
    SCOPED_TRACE("seed " + std::to_string(order.seed) + ", " + order.kind);
    EXPECT_EQ(study.verdict, other.verdict);
    EXPECT_THAT(other.not_testable, testing::UnorderedElementsAreArray(study.not_testable));
    ASSERT_EQ(study.findings.size(), other.findings.size());
    with_findings += study.findings.empty() ? 0 : 1;
    for (const auto& [name, parameters] : study.findings) {
      ASSERT_TRUE(other.findings.contains(name)) << name;
      // Numbers in a file of other units differ in the last digits that are written.
      for (const auto& [parameter, value] : parameters)
        EXPECT_NEAR(other.findings.at(name).at(parameter), value, 1e-3 * std::abs(value))
            << name << " " << parameter;
    }
  }
  EXPECT_GE(with_findings, kSeeds / 4);  // the comparison is of something
}

}  // namespace
}  // namespace driftwise::foreign
