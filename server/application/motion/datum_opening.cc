#include "server/application/motion/datum_opening.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/motion/joining.h"
#include "server/application/motion/loading.h"
#include "server/application/motion/motion.h"
#include "server/application/motion/sampling.h"
#include "server/application/motion/start_checks.h"
#include "server/application/motion/until_stored.h"
#include "server/application/motion/zero_visit.h"
#include "server/application/recording/doubts.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

Awaitable<Result<void>> stand_at_zero(RunScope& scope, const std::string& reason) {
  const std::vector<double> zero_mm(scope.bench.description.motor_channels().size(), 0.0);
  auto arrival = co_await go_to(scope, zero_mm, "zero: " + reason);
  for (int again = 0;
       arrival && arrival->trouble != Trouble::none && again < scope.rules.max_reapproaches;
       ++again)
    arrival = co_await go_to(scope, zero_mm, "zero: " + reason);
  DRIFTWISE_CO_RETURN_IF_ERROR(arrival);
  if (arrival->trouble != Trouble::none)
    co_return fail(ErrorCode::failed_precondition, reasons::kZeroNotReached,
                   "at the zero: " + arrival->sentence);
  co_return Result<void>{};
}

void add_means(std::vector<ChannelValue>& values, const CellDescription& description,
               const Sampling& sampling) {
  const auto channels = description.motor_channels();
  for (std::size_t i = 0; i < channels.size(); ++i)
    values.push_back({channels[i].name(), sampling.q_mm[i]});
  for (const auto& mean : sampling.means) values.push_back(mean);
}

// Where the scale stands when the instrument reads 0: the readings after the zeroing are 0 within
// their noise, and with one axis and one length that remainder is taken out.
void add_zero_of_scale(std::vector<ChannelValue>& values, const CellDescription& description,
                       const Sampling& new_zero) {
  const auto motors = description.motor_channels();
  const auto lengths = description.length_channels();
  for (std::size_t i = 0; i < motors.size(); ++i) {
    double q_mm = new_zero.q_mm[i];
    if (motors.size() == 1 && lengths.size() == 1)
      if (const double* x_mm = find_value(new_zero.means, lengths.front().name())) q_mm -= *x_mm;
    values.push_back({motors[i].name(), q_mm});
  }
}

// The length whose zero moved farthest from what was expected, and its comparison.
struct WorstZero {
  std::size_t length = 0;
  ZeroComparison comparison;
};

std::optional<WorstZero> worst_of(const DatumOpening& opening, const std::vector<double>& found_nm,
                                  const std::vector<double>& warming) {
  std::optional<WorstZero> worst;
  double farthest = -1;
  for (std::size_t i = 0; i < found_nm.size(); ++i) {
    if (is_missing(found_nm[i])) continue;
    const std::vector<ZeroObservation> none;
    const auto& seen = i < opening.closures.size() ? opening.closures[i] : none;
    const ZeroComparison comparison{predict_zero_shift(seen, warming), found_nm[i]};
    const double distance = std::abs(comparison.difference_nm()) / comparison.limit_nm();
    if (distance <= farthest) continue;
    farthest = distance;
    worst = WorstZero{i, comparison};
  }
  return worst;
}

// old_zero: what the instruments read at the zero just before they are zeroed; slow: the
// temperatures then. Empty: there is nothing to compare.
std::vector<ChannelValue> compare(const RunScope& scope, const DatumOpening& opening,
                                  const Sampling& old_zero, const std::vector<ChannelValue>& slow) {
  const auto& description = scope.bench.description;
  std::vector<ChannelValue> values;
  add_means(values, description, old_zero);
  const auto worst = worst_of(opening, closure_nm(description, *opening.before, values),
                              warming_since(description, *opening.before, slow));
  if (!worst) return {};
  const auto& comparison = worst->comparison;
  const auto lengths = description.length_channels();
  const auto which =
      lengths.size() > 1 ? lengths[worst->length].symbol + ", the worst of them: " : std::string();
  scope.bench.events.record_own(comparison.surprising() ? "zero.surprising" : "zero.compared",
                                which + comparison.sentence(), scope.run);
  return {{"zero_predicted_nm", comparison.predicted.shift_nm},
          {"zero_found_nm", comparison.found_nm},
          {"zero_difference_nm", comparison.difference_nm()},
          {"zero_limit_nm", comparison.limit_nm()}};
}

// The first zeroing since the datum before was opened, as its reading has it: that one compared the
// old zero, and took it away. It has no datum when it was interrupted.
Awaitable<Result<std::optional<Reading>>> zeroing_since(RunScope& scope, DatumRecord before) {
  auto& bench = scope.bench;
  auto looking =
      bench.writer.readings().readings(kZeroDevice, before.opened.utc, bench.clock.now().utc, 0);
  DRIFTWISE_CO_TRY(auto found, co_await std::move(looking));
  if (found.empty()) co_return std::nullopt;
  const double* difference_nm = find_value(found.front().values, "zero_difference_nm");
  bench.events.record_own(
      difference_nm ? "zero.compared" : "zero.not_compared",
      difference_nm
          ? fmt::format("as measured before a zeroing since datum {}: {:+.0f} nm from where the "
                        "old zero was expected",
                        before.id.value, *difference_nm)
          : fmt::format("the instruments were zeroed since datum {}: its zero cannot be measured "
                        "any more, the next return to zero decides",
                        before.id.value),
      scope.run);
  co_return std::move(found.front());
}

Awaitable<Result<void>> store_reading(StoreWriter& writer, const Reading& reading) {
  return writer.call(
      [](Store& store, const Reading& kept) {
        return store.readings().append(std::span<const Reading>(&kept, 1), {}, {});
      },
      reading);
}

// On disk before the first instrument is zeroed: whatever interrupts what follows, the old zero is
// measured from here on no more.
Awaitable<Result<Reading>> begin_zeroing(RunScope& scope, std::vector<ChannelValue> comparison) {
  const auto now = scope.bench.clock.now().utc;
  Reading zeroing{kZeroDevice, now, now, 0, std::move(comparison)};
  const auto store = [&] { return store_reading(scope.bench.writer, zeroing); };
  auto storing = until_stored(scope, store);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(storing));
  co_return zeroing;
}

const std::vector<SetupConfirmation>& confirmations_of(const RunScope& scope) {
  static const std::vector<SetupConfirmation> none;
  const auto* setup = scope.bench.devices.setup();
  return setup ? setup->confirmations : none;
}

// Counts from the new zero, or is a difference of what does.
bool is_of_confirmation(const RunScope& scope, const std::string& channel) {
  return std::ranges::any_of(confirmations_of(scope), [&channel](const SetupConfirmation& one) {
    return one.confirmed().name() == channel || one.difference().name() == channel;
  });
}

// Beside the old zero: the rotations that this zeroing counts from, and the force that acts.
void add_slow_of_zero(std::vector<ChannelValue>& values, const RunScope& scope,
                      const Sampling& new_zero) {
  const auto& description = scope.bench.description;
  for (const auto& angle : description.angle_channels())
    if (const double* arcsec = find_value(new_zero.raw, angle.name()))
      values.push_back({angle.name(), *arcsec});
  for (const auto& one : confirmations_of(scope))
    if (const double* value = find_value(new_zero.raw, one.confirmed().name()))
      values.push_back({one.confirmed().name(), *value});
  const auto force = description.force_channel();
  if (const auto known_n = scope.bench.loading.known_n(); force && known_n)
    values.push_back({force->name(), *known_n});
}

// Anew after each approach: the axes stand elsewhere by some nanometres.
Awaitable<Result<void>> zero_lengths(DeviceBench& devices) {
  for (const auto device : devices.with_role(DeviceRole::length))
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await devices.zero(device));
  co_return Result<void>{};
}

bool is_angle_of(const CellDescription& description, const std::string& channel) {
  for (const auto& angle : description.angle_channels())
    if (angle.name() == channel) return true;
  return false;
}

}  // namespace

const double* find_value(const std::vector<ChannelValue>& values, const std::string& channel) {
  for (const auto& value : values)
    if (value.channel == channel) return &value.value;
  return nullptr;
}

std::vector<double> warming_since(const CellDescription& description, const DatumRecord& datum,
                                  const std::vector<ChannelValue>& values) {
  std::vector<double> warming;
  for (const auto& channel : description.temperature_channels()) {
    const double* then = find_value(datum.values, channel.name());
    const double* now = find_value(values, channel.name());
    warming.push_back(then && now ? *now - *then : 0.0);
  }
  return warming;
}

std::vector<double> closure_nm(const CellDescription& description, const DatumRecord& datum,
                               const std::vector<ChannelValue>& values) {
  const auto lengths = description.length_channels();
  const auto motors = description.motor_channels();
  std::vector<double> closure;
  for (const auto& length : lengths) {
    const double* x_mm = find_value(values, length.name());
    closure.push_back(x_mm ? nm_from_mm(*x_mm) : kMissing);
  }
  if (lengths.size() == 1 && motors.size() == 1) {
    const double* q_mm = find_value(values, motors.front().name());
    const double* q_zero_mm = find_value(datum.values, motors.front().name());
    closure.front() -= q_mm && q_zero_mm ? nm_from_mm(*q_mm - *q_zero_mm) : kMissing;
  }
  return closure;
}

double largest_nm(const std::vector<double>& closure_nm) {
  double largest = kMissing;
  for (const double nm : closure_nm)
    if (!is_missing(nm) && !(std::abs(nm) <= std::abs(largest))) largest = nm;
  return largest;
}

Awaitable<Result<DatumRecord>> open_datum(RunScope& scope, DatumOpening opening,
                                          SwitchOn switch_on) {
  auto& bench = scope.bench;
  bench.doubts
      .forget_datum();  // what the instruments show until they are zeroed counts from elsewhere
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await make_homed(scope, opening.home, switch_on));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await stand_at_zero(scope, opening.reason));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await check_stabilisers(scope));

  std::optional<Reading> zeroing;  // that took the old zero away
  if (opening.before) {
    auto looking = zeroing_since(scope, *opening.before);
    DRIFTWISE_CO_TRY(zeroing, co_await std::move(looking));
  }
  // A lost beam fails here with BEAM_LOST: then there is no old zero to compare with, and zeroing
  // brings it back.
  const std::vector<double> zero_mm(bench.description.motor_channels().size(), 0.0);
  auto old_zero = co_await take_readings(scope, scope.rules.readings_per_point, zero_mm);
  const bool beam_was_lost = !old_zero && old_zero.error().reason == reasons::kBeamLost;
  if (!old_zero && !beam_was_lost) co_return tl::unexpected(old_zero.error());
  if (opening.check_drift && !beam_was_lost)
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await check_drift(scope));

  scope.phase("zeroing");
  ZeroVisit at_zero;
  at_zero.cause = "zero: " + opening.reason;
  at_zero.is_there = true;
  at_zero.in_datum = false;
  if (!beam_was_lost) {  // again, as close to the zeroing as can be
    auto visiting = visit_zero(scope, at_zero);
    old_zero = co_await std::move(visiting);
    DRIFTWISE_CO_RETURN_IF_ERROR(old_zero);
  }
  const bool has_old_zero = old_zero && !zeroing;
  if (!zeroing) {
    std::vector<ChannelValue> comparison;
    // A zero that went with the process is no old zero to compare with, as after a lost beam.
    if (has_old_zero && opening.before && bench.devices.knows_zeros()) {
      DRIFTWISE_CO_TRY(const auto slow, co_await join_when_scanned(scope, old_zero->measured.utc));
      comparison = compare(scope, opening, *old_zero, slow);
    }
    auto beginning = begin_zeroing(scope, std::move(comparison));
    DRIFTWISE_CO_TRY(zeroing, co_await std::move(beginning));
  }
  at_zero.arrived = [&bench] { return zero_lengths(bench.devices); };
  auto visiting = visit_zero(scope, std::move(at_zero));
  DRIFTWISE_CO_TRY(auto new_zero, co_await std::move(visiting));
  DRIFTWISE_CO_RETURN_IF_ERROR(bench.doubts.check_zero(new_zero.raw));

  DatumRecord datum{{}, scope.run, new_zero.measured, opening.reason, {}};
  add_zero_of_scale(datum.values, bench.description, new_zero);
  if (has_old_zero)
    for (const auto& mean : old_zero->means)
      if (!is_angle_of(bench.description, mean.channel) && !is_of_confirmation(scope, mean.channel))
        datum.values.push_back(mean);
  add_slow_of_zero(datum.values, scope, new_zero);
  DRIFTWISE_CO_TRY(auto slow, co_await join_when_scanned(scope, datum.opened.utc));
  datum.values.insert(datum.values.end(), slow.begin(), slow.end());
  for (const auto& value : zeroing->values) datum.values.push_back(value);

  // What is zeroed waits for the disk with its datum: zeroed again it would be another one.
  const auto store = [&] { return bench.writer.points().open_datum(datum); };
  auto storing = until_stored(scope, store);
  DRIFTWISE_CO_TRY(datum.id, co_await std::move(storing));
  bench.doubts.take_datum(datum);
  bench.events.record_own("datum.opened",
                          fmt::format("datum {}: {}", datum.id.value, opening.reason), scope.run);
  co_return datum;
}

}  // namespace driftwise::application
