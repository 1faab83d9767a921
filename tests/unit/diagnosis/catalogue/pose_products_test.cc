// Products of a pose with a temperature or a force: of higher order only where the simulation has
// the geometry, for x^2 times a temperature of 20 degC is x^2.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/diagnosis/catalogue/cause.h"
#include "server/effects/term_order.h"
#include "server/formats/formula/formula.h"

namespace driftwise::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::Not;

// Every term that a cause may have, with this baseline.
std::vector<std::string> terms_of_cause(const std::string& id, const std::string& formula) {
  Dataset data;
  data.rows = 60;
  data.columns = {
      {{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t01", "degC"}, {}}, {{"force", "N"}, {}}};
  for (std::size_t i = 0; i < data.rows; ++i) {
    data.time_s.push_back(30.0 * static_cast<double>(i));
    const double at[] = {static_cast<double>(i % 6), static_cast<double>(i % 6),
                         20 + 0.01 * static_cast<double>(i), static_cast<double>(i % 3)};
    for (std::size_t k = 0; k < 4; ++k) data.columns[k].values.push_back(at[k]);
  }
  std::vector<std::string> terms;
  for (const auto& cause :
       catalogue_for(data, formats::Formula::parse(formula)->expand(data)->terms, {}).causes)
    if (cause.id == id)
      for (const auto& cell : cause.cells)
        for (const auto& term : cell.terms) terms.push_back(effects::notation(term));
  return terms;
}

TEST(ProductsWithThePose, AreOfFirstOrderWhereTheBaselineHasNoHigherGeometry) {
  EXPECT_THAT(terms_of_cause("thermal_expansion", "q1 ~ x + T"), Contains("x:t01"));
  EXPECT_THAT(terms_of_cause("thermal_expansion", "q1 ~ x + T"), Not(Contains("x^2:t01")));
}

TEST(ProductsWithThePose, FollowTheGeometryToTheSecondOrderWithTemperatureAndTheThirdWithForce) {
  const std::string formula = "q1 ~ poly(x, 4) + T";
  EXPECT_THAT(terms_of_cause("thermal_expansion", formula), Contains("x^2:t01"));
  EXPECT_THAT(terms_of_cause("thermal_expansion", formula), Not(Contains("x^3:t01")));
  EXPECT_THAT(terms_of_cause("force_position_coupling", formula), Contains("x^3:force"));
  EXPECT_THAT(terms_of_cause("force_position_coupling", formula), Not(Contains("x^4:force")));
}

}  // namespace
}  // namespace driftwise::diagnosis
