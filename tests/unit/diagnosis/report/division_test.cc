// A robot that warms moves; an instrument that warms only reads as if the robot had moved. Fitted
// side by side each has its part, and where the data do not divide them the report says so and
// which run would.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <regex>

#include "server/core/data/dataset_parts.h"
#include "server/diagnosis/diagnose.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kRowsPerRun = 300;
constexpr double kRunStep_s = 60, kStructure_nm_per_k = 400, kSupport_nm_per_k = 250,
                 kLaserNoise_nm = 5;

struct DividedCampaign {
  double robot_start_k = 0;  // the structure's deviation from the air at the start, beyond 0.3 K
  bool instrument_alike = true;
  unsigned seed = 11;
};

// The structure (t01, on the robot) and the support of the instrument (t02) follow the room with
// time constants of 2 h and 2.3 h (alike), or of 2 h and 10 min.
Dataset divided_campaigns(const std::vector<DividedCampaign>& campaigns) {
  Dataset data;
  DatasetColumn q{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}}, t01{{"t01", "degC"}, {}},
      t02{{"t02", "degC"}, {}};
  double clock_s = 0;
  for (std::size_t c = 0; c < campaigns.size(); ++c) {
    std::mt19937_64 random(campaigns[c].seed);
    std::normal_distribution<double> normal;
    for (std::size_t row = 0; row < kRowsPerRun; ++row) {
      const double t_s = kRunStep_s * static_cast<double>(row);
      const auto relaxed = [&](double start_k, double tau_s) {
        return start_k * std::exp(-t_s / tau_s) + 0.1 * std::sin(t_s / 9000);
      };
      const double robot_k = relaxed(0.3 + campaigns[c].robot_start_k, 7200),
                   support_k = relaxed(0.3, campaigns[c].instrument_alike ? 8300 : 600);
      const double at_mm = -3 + 6 * std::fmod(0.618 * static_cast<double>(row), 1.0);
      x.values.push_back(at_mm);
      t01.values.push_back(20 + robot_k);
      t02.values.push_back(20 + support_k);
      q.values.push_back(at_mm +
                         1e-6 * (kStructure_nm_per_k * robot_k + kSupport_nm_per_k * support_k +
                                 kLaserNoise_nm * normal(random)));
      data.time_s.push_back(clock_s + t_s);
      data.run.push_back(static_cast<std::int64_t>(c) + 1);
      data.datum.push_back(static_cast<std::int64_t>(c) + 1);
    }
    clock_s += 86400;
  }
  data.rows = data.time_s.size();
  data.columns = {q, x, t01, t02};
  data.metadata.emplace_back(kPartsKey, parts_text({{"t01", "robot"}, {"t02", "instrument"}}));
  return data;
}

// The note of the division; "" for none.
std::string division_of(const Dataset& data) {
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse("q1 ~ x + t01 + t02")->expand(data);
  options.nulls = 49;
  const auto found = diagnose(data, options);
  if (!found) return found.error().message;
  for (const auto& warning : found->warnings)
    if (warning.find("rest on the robot") != std::string::npos) return warning;
  return "";
}

double nm_before(const std::string& text, const std::string& words) {
  std::smatch match;
  return std::regex_search(text, match, std::regex("([0-9.]+) nm" + words)) ? std::stod(match[1])
                                                                            : NAN;
}

double rms_from_first(const Dataset& data, const std::string& symbol, double nm_per_k) {
  const auto values = data.values_of(symbol);
  double squares = 0;
  for (const double value : values) squares += std::pow(nm_per_k * (value - values[0]), 2);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

TEST(Division, GivesEachSideItsPartWhereTheyDiffer) {
  const Dataset data = divided_campaigns({{.instrument_alike = false}});
  const std::string said = division_of(data);
  const double u90_nm = nm_before(said, "$");
  ASSERT_NE(said.find("they are told apart to"), std::string::npos) << said;
  EXPECT_LT(u90_nm, 5) << said;
  // 2.4 standard errors: seeded.
  EXPECT_NEAR(nm_before(said, " rms of the correction rest on the robot \\(t01\\)"),
              rms_from_first(data, "t01", kStructure_nm_per_k), 1.5 * u90_nm);
  EXPECT_NEAR(nm_before(said, " on instruments \\(t02\\)"),
              rms_from_first(data, "t02", kSupport_nm_per_k), 1.5 * u90_nm);
}

TEST(Division, SaysWhatTheDataDoNotDivideAndWhichRunWould) {
  const std::string said = division_of(divided_campaigns({{}}));
  ASSERT_NE(said.find("these data divide them to"), std::string::npos) << said;
  ASSERT_NE(said.find("begun 1 K warmer or colder"), std::string::npos) << said;
  EXPECT_LT(nm_before(said, "$"), 0.5 * nm_before(said, " only")) << said;
}

// The run that was offered, measured: the division is then known as was foretold.
TEST(Division, IsKnownAsForetoldOnceTheOtherStartWasMeasured) {
  const double foretold_nm = nm_before(division_of(divided_campaigns({{}})), "$");
  const std::string said = division_of(divided_campaigns({{}, {.robot_start_k = 1, .seed = 12}}));
  const double known_nm = nm_before(said, said.find("only") == std::string::npos ? "$" : " only");
  // Rms over other rows, and the standard deviation of the noise from twice as many.
  EXPECT_NEAR(known_nm / foretold_nm, 1, 0.35) << said;
}

// The support of the laser warms as the room does; the baseline does not read its thermometer.
TEST(Division, SaysThatANamedThermometerIsOnAnInstrument) {
  const Dataset data = divided_campaigns({{.instrument_alike = false}});
  DiagnoseOptions options;
  options.baseline = *formats::Formula::parse("q1 ~ x + t01")->expand(data);
  const auto found = diagnose(data, options);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->findings.size(), 1U);
  EXPECT_EQ(found->findings[0].cause + " " + found->findings[0].subject, "thermal_offset t02");
  EXPECT_EQ(std::ranges::count_if(found->warnings,
                                  [](const std::string& warning) {
                                    return warning.starts_with(
                                        "thermal_offset t02: t02 is on an instrument");
                                  }),
            1);
}

TEST(Division, IsSilentWhereNoThermometerIsOnAnInstrument) {
  Dataset data = divided_campaigns({{}});
  data.metadata.clear();
  EXPECT_EQ(division_of(data), "");
}

}  // namespace
}  // namespace driftwise::diagnosis
