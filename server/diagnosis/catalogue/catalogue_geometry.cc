// Geometry that the simulation lacks: powers of an axis, products of two or three.

#include <algorithm>

#include "server/core/data/reading.h"
#include "server/diagnosis/catalogue/catalogue_builder.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

using effects::AppliesTo;
using effects::Term;

constexpr int kDegreesBeyond = 3;  // of one axis
constexpr int kHighestKnown = 9;
constexpr double kWholeTurn_arcsec = 0.97 * 1296000;

Cause geometry(const std::string& subject) {
  return {.id = "geometry_order",
          .subject = subject,
          .where = "robot",
          .applies_to = AppliesTo::robot,
          .parameter = "degree"};
}

// All products of these axes, each at least once, of one total degree.
std::vector<Term> products_of_degree(const std::vector<std::string>& axes, int degree) {
  auto terms = monomials_of_degree(axes, degree);
  std::erase_if(terms, [&](const Term& term) { return term.factors.size() < axes.size(); });
  return terms;
}

// The lowest total degree of which the simulation lacks a product, and the next: each such term
// alone, and all of the lowest degree together.
void products(CatalogueBuilder& builder, const std::vector<std::string>& axes) {
  std::string subject;
  for (const auto& axis : axes) subject += (subject.empty() ? "" : ":") + axis;
  Cause cause = geometry(subject);
  int degree = static_cast<int>(axes.size());
  const auto all_known = [&](int d) {
    return std::ranges::all_of(products_of_degree(axes, d),
                               [&](const Term& term) { return builder.known(term); });
  };
  while (degree < kHighestKnown && all_known(degree)) ++degree;
  for (int d = degree; d <= degree + 1; ++d)
    for (const auto& term : products_of_degree(axes, d))
      builder.add_terms(cause, {term}, static_cast<double>(d));
  builder.add_terms(cause, products_of_degree(axes, degree), static_cast<double>(degree));
  builder.take_cause(std::move(cause));
}

}  // namespace

void add_geometry(CatalogueBuilder& builder) {
  std::vector<std::string> axes;
  for (const auto& axis : builder.axes()) {
    if (builder.is_angle(axis) && builder.range(axis) >= kWholeTurn_arcsec)
      builder.missing("geometry_order", axis +
                                            " turns all around: what errs with it comes back "
                                            "after a turn, as no power of it does");
    else
      axes.push_back(axis);
  }
  for (const auto& axis : axes) {
    Cause cause = geometry(axis);
    int degree = 0;
    while (degree < kHighestKnown && builder.known(power_term(axis, degree + 1))) ++degree;
    std::vector<Term> terms;
    for (int d = degree + 1; d <= degree + kDegreesBeyond; ++d) {
      builder.add_terms(cause, {power_term(axis, d)}, d);
      terms.push_back(power_term(axis, d));
      builder.add_terms(cause, terms, d);
    }
    builder.take_cause(std::move(cause));
  }
  for (std::size_t i = 0; i < axes.size(); ++i)
    for (std::size_t j = i + 1; j < axes.size(); ++j) products(builder, {axes[i], axes[j]});
  if (axes.size() == 3) products(builder, axes);
  if (builder.axes().empty()) builder.missing("geometry_order", "no pose coordinate varies");
  builder.missing("geometry_parameter", "no kinematic model is given");
}

}  // namespace driftwise::diagnosis
