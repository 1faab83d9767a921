#pragma once
// What a selection strives for, as numbers.
//
// Information criteria are those of R's extractAIC and step(): n ln(RSS / n) + c k, with n rows of
// weight above 0, k coefficients (the constant and datum constants counted), c = 2 (Akaike 1974) or
// ln n (Schwarz 1978). Only differences mean anything: the likelihood's constants are left out.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace driftwise::calibration {

// p: thresholds on the partial F test, NUMERICS.md section 1. bic, aic: the single change that
// lowers the criterion most, until none does.
enum class Criterion : std::uint8_t { p, bic, aic };

std::string to_string(Criterion criterion);                       // "p", "bic", "aic"
std::optional<Criterion> criterion_named(std::string_view name);  // the same, in either case

// c above: the price of one more coefficient. For p, which has none, BIC's: it then only ranks what
// several starts found.
double price_per_term(Criterion criterion, std::int64_t rows);

// n ln(RSS / n) + price k; none where nothing is left to explain (RSS 0) or no rows.
std::optional<double> information(double rss, std::int64_t rows, std::int64_t coefficients,
                                  double price);

// Change of the criterion when one term enters or leaves, from that term's partial F: exact where a
// difference of two sums of squares would have no digits. dof: rows less coefficients of the
// larger model.
double change_by_entering(double f, std::int64_t dof, std::int64_t rows, double price);
double change_by_leaving(double f, std::int64_t dof, std::int64_t rows, double price);

}  // namespace driftwise::calibration
