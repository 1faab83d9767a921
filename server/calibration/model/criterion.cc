#include "server/calibration/model/criterion.h"

#include <cmath>

namespace driftwise::calibration {

std::string to_string(Criterion criterion) {
  switch (criterion) {
    case Criterion::bic:
      return "bic";
    case Criterion::aic:
      return "aic";
    case Criterion::p:
      break;
  }
  return "p";
}

std::optional<Criterion> criterion_named(std::string_view name) {
  if (name == "p") return Criterion::p;
  if (name == "bic" || name == "BIC") return Criterion::bic;
  if (name == "aic" || name == "AIC") return Criterion::aic;
  return std::nullopt;
}

double price_per_term(Criterion criterion, std::int64_t rows) {
  return criterion == Criterion::aic ? 2 : std::log(static_cast<double>(rows));
}

std::optional<double> information(double rss, std::int64_t rows, std::int64_t coefficients,
                                  double price) {
  if (!(rss > 0) || rows < 1) return std::nullopt;
  const auto n = static_cast<double>(rows);
  return n * std::log(rss / n) + price * static_cast<double>(coefficients);
}

// RSS without the term = RSS with it * (1 + F / dof).
double change_by_entering(double f, std::int64_t dof, std::int64_t rows, double price) {
  return price - static_cast<double>(rows) * std::log1p(f / static_cast<double>(dof));
}

double change_by_leaving(double f, std::int64_t dof, std::int64_t rows, double price) {
  return -change_by_entering(f, dof, rows, price);
}

}  // namespace driftwise::calibration
