#pragma once
// A snapshot: the model partially evaluated at the present slow conditions.
//
// A model's terms are products of fast factors (pose, force: known only when a target is asked for)
// and slow ones (temperatures, pressure, effects with memory: the same for every target of the next
// seconds). With S the matrix that holds the present slow value of term k in the column of its fast
// product, q = c' (S b) with b the fast basis 1, x, x^2, ..., F. The snapshot holds S'c and S'C S
// (C the coefficients' covariance): a target then costs one short dot product and its variance one
// small quadratic form b' V b.
//
// Built by SnapshotBuilder, published on a SnapshotBoard, immutable afterwards: any thread may read
// it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/channel.h"
#include "server/core/description/cell_description.h"
#include "server/core/ids.h"
#include "server/core/result.h"
#include "server/core/units.h"

namespace driftwise::compensation {

// What a request states. Pose lengths in mm, rotations in arcsec, force in N.
enum class Variable : std::uint8_t { x, y, z, rx, ry, rz, force };
constexpr std::size_t kVariables = 7;
constexpr std::size_t kMaxOutputs = 16;
constexpr std::size_t kMaxBasis = 128;  // poly(x, y, z, rx, ry, 3) has 56 products, with force 84
constexpr std::size_t kMaxInputs = 64;  // a bit each in Target
constexpr std::uint32_t bit(Variable variable) { return 1u << static_cast<unsigned>(variable); }
std::optional<Variable> variable_from(std::string_view symbol);
// In the request's unit: x_mm, rx_arcsec, force_N.
Channel channel_of(Variable variable);
std::string_view name_of(Variable variable);
std::optional<Variable> variable_named(std::string_view name);

// Where a target's uncertainty comes from, line by line; what each means and how it is combined:
// docs/uncertainty.md.
enum class UncertaintySource : std::uint8_t {
  fit,             // covariance of the coefficients, allowing for autocorrelation
  residual,        // what the robot does and the model does not follow
  temperatures,    // each slow input's uncertainty through the model's sensitivity to it
  laser,           // the interferometer's reading at the zero
  drift,           // ... and its slow drift, as far as the coefficients took it up
  beam_offset,     // lever arms not known better: tilt x offset
  tilts,           // the autocollimators' error on the known lever arms
  beam_direction,  // beams not square to one another
  mirror,          // flatness
  force,           // of what hangs
  scale,           // reading of the motor's scale
  extrapolation,   // outside the fitted domain; only in a Budget
};
constexpr std::size_t kUncertaintySources = 12;
std::string_view to_string(UncertaintySource source);

// The fitted range is that of measured poses and temperatures, so a wanted 4 mm may stand a few
// nanometres outside a measured 3.9999 mm: this share of the range is still called inside, on each
// side, by the daemon and by an exported model.
constexpr double kDomainSlack = 0.005;

// Distance of a value from a domain, in half widths of it; 0 inside. A domain without width: 1.
double excess_of(double min, double max, double value);

class GeometryLaw;  // geometry_law.h

// A model's own geometry at the present conditions; its motor coordinates add to the polynomial's.
struct PresentGeometry {
  std::shared_ptr<const GeometryLaw> law;
  std::vector<double> temperatures, u_temperatures;  // of law->temperatures(), in their units
  std::vector<double> standing;  // motor coordinates as last read, outputs' units; kMissing: never
  bool from_zero = false;        // geometry(pose) - geometry(0): the zero is in the polynomial
  // Declared errors of standard size: what they did to the free parameters, whose order and units
  // these are. Source and number are those of the same error's rows in UncertaintyLine.
  struct ParameterError {
    UncertaintySource source;
    std::uint32_t number = 0;
    bool shared_with_zero = true;
    std::vector<double> shift;
  };
  std::vector<ParameterError> errors = {};
};

struct Snapshot {
  ModelId model;
  CellTime built_at, valid_until;

  // The basis: b[0] = 1, b[k + 1] = b[products[k].base] * value[products[k].variable], base <= k.
  struct Product {
    std::uint16_t base = 0;
    std::uint8_t variable = 0;
    bool operator==(const Product&) const = default;
  };
  std::vector<Product> products;
  std::size_t basis_size() const { return products.size() + 1; }
  std::uint32_t needed = 0;  // bit per Variable
  // Value in the model's column = column_per_unit * value in the request's unit + column_shift.
  std::array<double, kVariables> column_per_unit{};
  std::array<double, kVariables> column_shift{};  // of another datum: SnapshotBuilder::anchor

  struct UncertaintyLine {
    UncertaintySource source = UncertaintySource::fit;
    std::vector<double>
        variance_nm2;  // packed lower triangle (row by row) over the basis, or 1 entry: constant
    // Instead of it, errors that each have one size for all poses: rows of basis_size() numbers.
    // The variance is the sum over the rows of (row . basis)^2.
    std::vector<double> roots_nm{};
    // Per row, which error it is: rows of several outputs with one source and number are one error,
    // with its sign in each of them. Empty: every row is an error of its own.
    std::vector<std::uint32_t> errors{};
  };
  struct Output {
    // q1_mm: results are in mm whatever the model's column. A joint of an arm, q1_rad or q1_deg:
    // that unit stands wherever mm is written, here and in targets, and 1e-6 of it wherever nm is.
    Channel channel;
    std::vector<double> coefficients_mm;  // one per basis entry
    std::vector<double>
        thermal_mm{};  // of them, what the slow inputs put in: since the datum's zero,
                       // or from the middle of their ranges; empty: nothing slow
    // Of the lines together the variance is the sum over i of the squares of sum over j >= i of
    // root_nm(i, j) * basis[j], the rows one after another, and of the packed form (off-diagonal
    // entries doubled) of a model whose covariance has no root. Empty: none.
    std::vector<double> root_nm{};
    std::vector<double> variance_nm2;
    std::vector<UncertaintyLine> lines;
    // The axis' soft limits in force when the snapshot was built; infinite: see unlimited.
    double min_mm = -std::numeric_limits<double>::infinity();
    double max_mm = std::numeric_limits<double>::infinity();
  };
  std::vector<Output> outputs;  // empty: no model serves
  // Why the model that should serve does not: what every request is answered with. Without: nothing
  // is promoted.
  std::optional<Error> unserved;

  // What the model depends on, with the domain it was fitted in.
  struct Input {
    Channel channel;
    std::optional<Variable> variable;  // a fast one; none: slow
    double min = 0, max = 0;  // of the domain, in the request's unit (fast) or the column's (slow)
    double value = 0, u = 0;  // slow: what was folded in, and its standard uncertainty
    CellTime at;              // slow: when it was measured
    std::optional<std::size_t> output = {};  // a motor coordinate with a domain: of that output
  };
  std::vector<Input> inputs;
  // Of the slow inputs, worked out once: a bit per input.
  std::uint64_t outside = 0, stale = 0, missing = 0;
  std::uint32_t unlimited = 0;  // a bit per output without known soft limits
  double slow_excess = 0;       // see extrapolation_factor in target.cc
  // Of the zero of a carried datum: inputs outside the domain at pose 0 under the conditions then,
  // and the largest excess of them. A target is a difference of the model from there.
  std::uint64_t zero_outside = 0;
  double zero_excess = 0;
  bool anchored = true;
  bool refuse_stale = false, refuse_outside_domain = false, refuse_outside_limits = true;
  // The cell file has changed, and nobody has answered yet. changed_parts: changes in what this
  // model uses, for people; empty: none.
  bool configuration_changed = false;
  std::string changed_parts{};
  std::optional<PresentGeometry> geometry{};  // none: the polynomials alone
  // No data judged the model (an imported geometry): targets have no uncertainty, and a flag.
  bool unjudged = false;
  // Measurements since it was made disagree with it (check standard): recalibrate. A flag only.
  bool doubtful = false;
};

}  // namespace driftwise::compensation
