#pragma once
// A target: motor coordinates for a wanted pose under the present conditions, with uncertainty and
// flags.
//
// compute_target is a pure function of (snapshot, request): no clock, lock or exception, any
// thread. A fitted inverse geometric model is a direct formula: nothing iterates, nothing is
// allocated. Of a model with a geometry the law answers (geometry_law.h), which allocates and, for
// an arm, iterates. Cost: docs/target-line.md, tests/bench.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/compensation/snapshot.h"

namespace driftwise::compensation {

constexpr std::size_t kMaxJoints = 9;

struct TargetRequest {
  std::array<double, kVariables> value{};  // by Variable: mm, arcsec, N
  std::uint32_t given = 0;                 // bit per Variable: which of them the caller stated
  bool with_uncertainty = true;
  bool show_unreachable = false;  // numbers beyond the soft limits too, flagged: for people
  CellTime now;                   // utc_ns 0: the snapshot's age is not looked at
  // Of an arm's solutions the nearest to these angles, joint q1 first. A bit per joint: stated;
  // the others: where the joint stands.
  std::array<double, kMaxJoints> near_rad{};
  std::uint32_t near = 0;

  void set(Variable variable, double v) {
    value[static_cast<std::size_t>(variable)] = v;
    given |= bit(variable);
  }
};

enum class NearName { taken, unknown, twice };
// channel: "q2_rad" or "q2_deg", of a joint 1 to kMaxJoints.
NearName set_near(TargetRequest& request, std::string_view channel, double value);

// A joint's standard uncertainty from 1e-6 of its channel's unit, as u_nm has it.
double arcsec_of(const Channel& joint, double micro_units);

enum TargetFlag : std::uint32_t {
  kOutsideDomain =
      1u << 0,  // a pose, force or temperature the model was not fitted for: see outside
  kStaleTemperature = 1u << 1,  // older than the cell's [serving] max_age_s: see stale
  kMissingTemperature =
      1u << 2,  // never read: the middle of the fitted range stands in for it, see missing
  kExpiredConditions =
      1u << 3,  // nobody rebuilt the snapshot in time: request.now is past valid_until
  kUnanchoredDatum =
      1u << 4,  // the present datum is not known: the constant is that of the model's own datum
  kOutsideLimits = 1u << 5,         // beyond the axes' soft limits: see unreachable
  kUnknownLimits = 1u << 6,         // the cell knows no soft limits of an axis: see unlimited
  kIgnoredCoordinate = 1u << 7,     // the model does not depend on a stated coordinate: see ignored
  kConfigurationChanged = 1u << 8,  // the cell file has changed, in parts that this model does not
                                    // use; nobody has accepted it yet
  kUnjudgedModel =
      1u << 9,  // an imported geometry: neither its domain nor its uncertainty is known
  kZeroOutsideDomain =
      1u << 10,  // the zero of the present datum was taken outside: see Snapshot::zero_outside
  kDoubtfulModel = 1u << 11,  // the last check of the model against new measurements failed
};

enum class Refusal : std::uint8_t {
  none,
  no_model,               // nothing is promoted
  missing_coordinate,     // the model needs a coordinate or a force that the request lacks: see
                          // missing
  not_finite,             // the request holds NaN or an infinity: see missing
  outside_domain,         // [serving] refuse_outside_domain; or so far out that no number comes
  stale,                  // [serving] refuse_stale: stale, missing or expired
  outside_limits,         // [serving] refuse_outside_limits: see unreachable
  configuration_changed,  // the cell file has changed in a part that the model uses: a person has
                          // to accept it first
  no_pose,                // the geometry has no answer: out of reach, singular, where it stands is
                          // not known; or a variance that has lost its digits; see why
};

struct Target {
  std::size_t outputs = 0;  // how many entries below are meant, in order of Snapshot::outputs
  // Not set beyond outputs: zeros for sixteen of each cost more than a small model's arithmetic.
  std::array<double, kMaxOutputs> q_mm;
  std::array<double, kMaxOutputs> u_nm;  // standard uncertainty; NaN when it was not asked for or
                                         // is not known (kUnjudgedModel)
  std::uint32_t flags = 0;               // TargetFlag
  std::uint64_t outside = 0, stale = 0, missing = 0;  // a bit per entry of Snapshot::inputs
  std::uint32_t unreachable = 0, unlimited = 0;  // a bit per output: beyond its limits; none known
  std::uint32_t ignored = 0;                     // a bit per Variable
  double unreachable_mm = 0;                     // of the lowest output in unreachable
  Refusal refusal = Refusal::none;     // with one, q_mm is NaN: there is nothing to move to
  std::shared_ptr<const Error> why{};  // of Refusal::no_pose
  CellTime valid_until;

  double expanded_nm(std::size_t i) const { return 2.0 * u_nm[i]; }     // k = 2
  double u90_nm(std::size_t i) const { return kSigmaToU90 * u_nm[i]; }  // 1.645 u
};

Target compute_target(const Snapshot& snapshot, const TargetRequest& request) noexcept;
// The same with the caller's terms (basis_values.h): cleared, or of this pose and a model with the
// same terms. They stay for slopes, and for the next such model. target: a new one.
class PoseTerms;
void compute_target(const Snapshot& snapshot, const TargetRequest& request, PoseTerms& terms,
                    Target& target) noexcept;

// Whether compute_target searches for an arm's joints, which takes milliseconds: not for a thread
// that others wait for.
bool needs_search(const Snapshot& snapshot, const TargetRequest& request) noexcept;
// Whether it is true of some request: an arm's joints.
bool may_search(const Snapshot& snapshot) noexcept;

// Flags, limits and refusals of motor coordinates that are given, at the pose that they make: what
// a target says of those that it found. No uncertainties. q_mm: one per Snapshot::outputs.
struct JudgedMotors {
  Target target;
  double factor = 1;  // of extrapolation, on uncertainties
};
JudgedMotors judge_motors(const Snapshot& snapshot, const TargetRequest& request,
                          std::span<const double> q_mm) noexcept;

// One line of the uncertainty budget of one output at one pose.
struct BudgetLine {
  UncertaintySource source;
  double u_nm = 0;
};
struct Budget {
  std::size_t lines = 0;
  std::array<BudgetLine, kUncertaintySources> line;
  double u_nm = 0;  // the root of the sum of squares: equals Target::u_nm
};
// found: Target::q_mm of the same request, so that an arm's joints are not looked for again.
Budget compute_budget(const Snapshot& snapshot, const TargetRequest& request, std::size_t output,
                      std::span<const double> found = {}) noexcept;

// The uncertainty of all outputs of a target, parted by what they share.
struct ErrorParts {
  double factor = 1;            // of extrapolation, on everything below
  std::vector<double> own_nm2;  // per output: variance of what it shares with no other
  // Per error that outputs share, of standard size: what it is in each of them, with its sign.
  std::vector<std::vector<double>> shared_nm;
};
// Empty where the request cannot be answered. Allocates.
ErrorParts error_parts(const Snapshot& snapshot, const TargetRequest& request);

// "OUTSIDE_DOMAIN(x_mm),STALE_TEMPERATURE(t07_degC)", "" when there is none. between: parts several
// names of one flag. append_flags allocates only where out lacks the room.
void append_flags(std::string& out, const Snapshot& snapshot, const Target& target, char between);
std::string describe_flags(const Snapshot& snapshot, const Target& target);

// The refusal as the error a client sees: NO_MODEL, MISSING_COORDINATE, NOT_FINITE, OUTSIDE_DOMAIN,
// STALE, CONFIGURATION_CHANGED, OUTSIDE_LIMITS(q3) with the motor coordinates that lie beyond,
// joined by '+'; what the geometry says (geometry_law.h).
Error refusal_error(const Snapshot& snapshot, const Target& target);

}  // namespace driftwise::compensation
