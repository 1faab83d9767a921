#pragma once
// Turns a model and the observed stream of readings into snapshots.
//
// Feed it every reading from the moment the daemon has them (after a restart: the stored ones
// first). Only this observed stream advances effects with memory; asking for a snapshot or a target
// never does. One thread.

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/compensation/basis_plan.h"
#include "server/compensation/geometry_law.h"
#include "server/compensation/slow_state.h"
#include "server/compensation/snapshot.h"
#include "server/core/data/reading.h"
#include "server/core/description/cell_description.h"
#include "server/core/result.h"
#include "server/effects/time_constant.h"

namespace driftwise::compensation {

// What a model's outputs are.
enum class Gives : std::uint8_t {
  motors,       // motor coordinates in a length unit
  coordinates,  // coordinates of the pose, as of a parasitic motion: x_mm, rx_arcsec
};

class SnapshotBuilder {
 public:
  // The cell gives the serving rules and every declared uncertainty (declared_errors.h). Errors,
  // failed_precondition: NOT_A_MOTOR_MODEL (an output that is no motor coordinate in a length
  // unit), TERM_NOT_SERVABLE (a term that reads a motor coordinate, an effect that reads the wanted
  // pose, terms or a constant beside an arm's geometry), NO_DOMAIN (a channel without its fitted
  // range), MODEL_TOO_LARGE (kMaxBasis, kMaxInputs, kMaxOutputs). Of coordinates: an angle's arcsec
  // stands wherever mm is written, in the snapshot and in its targets, and 1e-6 arcsec wherever nm
  // is. They have no soft limits.
  static Result<SnapshotBuilder> create(calibration::Model model, ModelId id,
                                        const CellDescription& cell, Gives gives = Gives::motors);

  // In time order. Channels that the model does not use are passed over; kMissing values change
  // nothing, so that the last good one grows old.
  void observe(const Reading& reading) { observe(reading.values, reading.middle()); }
  void observe(std::span<const ChannelValue> values, CellTime at) {
    slow_.observe(values, at);
    if (law_) observe_motors(values);
  }

  // Every slow channel at the middle of its fitted range. Errors: none; a channel without a range
  // stays unread.
  void observe_middle(CellTime at);

  // Full names, as the cell reads them, of the channels that no request states.
  std::vector<std::string> slow_channels() const;
  // Those and the motors of a geometry: the channels that observe() does not pass over.
  std::vector<std::string> observed_channels() const;
  // Time back to which readings count: effects with memory have forgotten what was before
  // (effects::kForgottenTaus). 0: the model has no such effect. Where the readings begin later, the
  // past is uncertain by the fitted range of the channel, in the line `temperatures`.
  Nanoseconds memory() const {
    return nanoseconds_from_s(effects::kForgottenTaus * slow_.longest_tau_s());
  }

  // The zero of the present datum: motor coordinates read back (and force, where the model has it)
  // at pose 0, with every temperature at that instant. From here on q = q_zero + f(pose + p0, now)
  // - f(p0, then), coefficients' covariance included, so that the constant of the model's own datum
  // drops out. p0: where that zero lies in the model's datum, f(p0, then) = q_zero; 0 where the
  // model has another number of motors than of axes, or that is more than 2 % of a fitted range
  // away. A coordinate of the pose was zeroed with the datum: its q_zero and p0 are 0. Effects with
  // memory count as they stand when this is called. Without it targets stay
  // in the model's datum and are flagged. So a datum of the past is anchored in a replay, after the
  // readings up to its zero. Errors: failed_precondition, INCOMPLETE_DATUM, naming the channel that
  // is not among the values, or the one of an effect that has seen no reading yet; the datum before
  // is no longer present, so targets are those without one.
  Result<void> anchor(std::span<const ChannelValue> values);
  // The datum that another builder of the same model was anchored in.
  void keep_anchor_of(const SnapshotBuilder& other);
  // The present datum is the model's own: nothing to shift.
  void keep_model_datum();

  // What every target until the next rebuild is computed from. Pure: now only decides about ages.
  Snapshot build(CellTime now) const;

  const calibration::Model& model() const { return model_; }

 private:
  struct Term {             // of one output, as served
    std::size_t basis = 0;  // its fast product
    SlowProduct slow;
    double coefficient = 0;  // column unit
  };
  struct Systematic {  // a declared error of standard size, as a shift of the terms; column units
    UncertaintySource source;
    Eigen::VectorXd shift;
    bool shared_with_zero = true;
    Eigen::VectorXd in_rows{};  // of a reading at the zero: what the rows' noise has of it, which
                                // is in the covariance; empty: nothing
    std::uint32_t number = 0;   // of its source: one error in several outputs has one
  };
  struct Output {
    Channel channel;         // q1_mm
    double mm_per_unit = 1;  // of the model's column
    std::vector<Term> terms;
    Eigen::MatrixXd covariance;  // of the terms, column units
    Eigen::MatrixXd root;        // of it, a row per term; empty: a model of before has none
    // The same less what the zero's readings share with the rows (Systematic::in_rows).
    Eigen::MatrixXd root_beside_zero;
    std::vector<Systematic> systematics;
    std::vector<Eigen::VectorXd> absorbed;  // per slow channel: shift of the terms per unit of its
                                            // error, empty: not known
    double unfollowed_nm = 0;               // of the residual, beyond the instruments' own noise
    double u_scale_nm = 0;
    std::optional<std::pair<double, double>> travel_mm;  // soft limits; none: not known
  };
  struct SlowInput {
    double min = 0, max = 0, u = 0;
  };  // one per channel of slow_
  struct FastInput {
    Variable variable;
    double min = 0, max = 0;
  };              // request's unit
  struct Datum {  // of one output, at the zero
    double q_mm = 0;
    std::vector<double> term_values;  // of every term: f(0, then) = sum of coefficient * value
    std::vector<std::vector<double>> term_slopes;  // [slow channel][term]: by that channel
    std::vector<std::vector<double>> term_shifts;  // [effect][term]: by what it did not see
  };
  struct Conditions {  // the slow side at the instant of building
    std::vector<double> channels, calls, u_systematic, u_independent;
    CallSlopes call_slopes;
    std::vector<double> call_shifts;           // SlowState::call_shifts
    std::vector<double> middle, middle_calls;  // of the fitted ranges, in equilibrium
  };

  SnapshotBuilder() = default;
  void forget_datum();
  // p0 of anchor(), in the columns' units; pose: of the zero, with its force.
  std::array<double, kVariables> pose_at_zero(std::array<double, kVariables> pose,
                                              const std::vector<double>& channels,
                                              const std::vector<double>& calls,
                                              const std::vector<double>& q_mm) const;
  Result<void> add_output(const calibration::OutputModel& output);
  // Outputs, inputs and temperatures of the model's geometry.
  Result<void> add_geometry();
  void observe_motors(std::span<const ChannelValue> values);
  double drift_reference(const Channel& channel) const;
  void add_parameter_error(const std::string& channel, const std::string& by, double size,
                           const Systematic& of_terms);
  PresentGeometry present_geometry(const Conditions& conditions) const;
  void add_uncertainty(const calibration::OutputModel& from, const CellDescription& cell,
                       Output& output);
  void add_errors_of_arm(const CellDescription& cell);
  std::uint32_t number_of(const std::string& error);
  // Of every output, from the residuals of all.
  void add_own_scatter(const CellDescription& cell);
  // Share of the readings at the zero that the rows' noise has. noise_nm2: of the instruments.
  static void share_noise(const calibration::OutputModel& from, double noise_nm2, Output& output);
  Result<Term> split(const effects::Term& term);
  Result<void> add_fast_input(const Channel& channel, const calibration::ChannelRange& range);
  const calibration::ChannelRange* domain_of(const std::string& symbol) const;
  // Of the model; infinite where a geometry has none of it.
  calibration::ChannelRange range_of(const Channel& channel) const;
  Conditions look_at_inputs(CellTime now, Snapshot& snapshot) const;
  // Excess of each input at the zero (excess_of()), in the order of Snapshot::inputs.
  std::vector<double> excess_at_zero(double force, const std::vector<double>& channels) const;
  Snapshot::Output fold(std::size_t output, const Conditions& conditions) const;
  std::vector<double> form_of(std::size_t output, const std::vector<long double>& slow,
                              const std::vector<long double>& at_zero) const;

  calibration::Model model_;
  ModelId id_;
  Gives gives_ = Gives::motors;
  ServingRules rules_;
  BasisPlan basis_;
  SlowState slow_;
  std::vector<Output> outputs_;
  std::map<std::string, std::uint32_t> numbers_;  // of declared errors
  std::vector<FastInput> fast_inputs_;
  std::array<double, kVariables> column_per_unit_{}, column_shift_{};
  std::vector<SlowInput> slow_inputs_;
  std::vector<Datum> datum_;                // one per output when anchored
  std::vector<double> zero_excess_;         // of that zero, by input
  std::shared_ptr<const GeometryLaw> law_;  // none: terms alone
  std::vector<PresentGeometry::ParameterError> parameter_errors_;
  std::vector<double> standing_;  // motor coordinates as last read, one per output
  bool anchored_ = false;
};

}  // namespace driftwise::compensation
