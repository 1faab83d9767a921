#include "server/application/recording/doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

constexpr const char* kPose = "pose";
constexpr const char* kReadback = "readback";
constexpr const char* kZero = "zero";
// A single false answer is shown for so long.
constexpr double kShown_s = 10;

}  // namespace

Doubts::Doubts(const CellDescription& cell, Clock& clock, StoreWriter& writer, EventLog& events,
               std::function<void()> on_news)
    : cell_(cell),
      clock_(clock),
      writer_(writer),
      events_(events),
      on_news_(std::move(on_news)),
      values_(cell),
      geometry_(cell) {}

JudgedReading Doubts::judge(Reading answer) {
  JudgedReading reading{std::move(answer), {}};
  for (const auto& finding : values_.judge(reading)) {
    const bool is_late = finding.test == "frozen" || finding.test == "together";
    if (is_late && (!suspicion_ || finding.since < suspicion_->since) &&
        standing_.find(finding.channel) == standing_.end())
      suspicion_ = Suspicion{finding.since, finding.reason};
    begin(finding.channel, "reading." + finding.test, finding.reason);
  }
  for (const auto& value : reading.values)
    if (!reading.is_rejected(value.channel)) end(value.channel);
  for (const auto& value : reading.rejected)
    writer_.add(RejectedAnswer{reading.device, reading.start, reading.sequence, value});
  return reading;
}

Result<void> Doubts::judge(const DeviceDescription& controller, const MotionState& state) {
  note_controller(controller, state);
  if (!state.referenced) return {};
  Reading answer{controller.id, state.at, state.at, 0, {}};
  for (std::size_t i = 0; i < std::min(controller.axes().size(), state.q_mm.size()); ++i)
    answer.values.push_back({controller.axes()[i].channel.name(), state.q_mm[i]});
  auto reading = judge(std::move(answer));
  if (reading.rejected.empty()) return {};
  auto error = implausible(reading.rejected.front().reason);
  writer_.add(std::move(reading));
  return tl::unexpected(std::move(error));
}

// Statements of a controller about itself. A servo that is off before the axes are referenced has
// not been switched on yet.
void Doubts::note_controller(const DeviceDescription& controller, const MotionState& state) {
  if (!state.old_error.empty())
    events_.record_own("motion.controller_error",
                       fmt::format("{} at {} reported {}: it is no answer to a command of this "
                                   "daemon",
                                   controller.id, controller.address, state.old_error));
  const auto subject = "servo of " + controller.id;
  if (state.servo_on || !state.referenced) {
    if (standing_.erase(subject) == 0) return;
    if (state.servo_on) events_.record_own("motion.servo_on", "the " + subject + " is on again");
    on_news_();
    return;
  }
  auto& standing = standing_[subject];
  const bool is_new = standing.kind.empty();
  standing = {"motion.servo_off",
              fmt::format("the servo of {} at {} is off although its axes are referenced: look who "
                          "switched it off and why. Nothing switches it on by itself: home, or "
                          "switch it on at the controller",
                          controller.id, controller.address),
              clock_.now().utc, false};
  if (is_new) on_news_();
}

JudgedReading Doubts::judged(const DeviceDescription& load, const LoadState& state,
                             std::int64_t sequence) {
  Reading reading{load.id, state.at, state.at, sequence, {}};
  reading.values.push_back({load.force()->name(), state.resting ? state.force_n : kMissing});
  auto answer = judge(std::move(reading));
  const std::string channel = load.force()->name();
  if (!state.resting || !is_missing(state.force_n)) return answer;
  // While weights move there is none; at rest there must be one.
  answer.rejected.push_back({channel, "missing", channel + " has no value although it rests"});
  begin(channel, "reading.missing", answer.rejected.back().reason);
  writer_.add(RejectedAnswer{answer.device, answer.start, answer.sequence, answer.rejected.back()});
  return answer;
}

// False where the cell file says that equal answers are no fault: [[limit]] frozen_answers = 0.
bool Doubts::may_freeze(const DeviceDescription& device) const {
  return plausibility::limit_of(cell_, device, device.length()->channel.name()).frozen_answers != 0;
}

Result<void> Doubts::check_round(std::vector<JudgedReading>& round,
                                 const std::vector<double>& q_mm) {
  std::optional<std::string> first;
  for (auto& reading : round) {
    const auto* device = cell_.find_device(reading.device);
    if (device == nullptr) continue;
    if (device->length() && may_freeze(*device) &&
        !reading.is_rejected(device->length()->channel.name()))
      if (const double* length = reading.find(device->length()->channel.name());
          length && moved_.is_frozen(device->length()->channel.name(), *length,
                                     of_robot(q_mm, device->length()->channel.symbol))) {
        const std::string name = device->length()->channel.name();
        auto reason = fmt::format("{} is {:.9g} although the axes moved", name, *length);
        if (!standing_.contains(name)) suspicion_ = Suspicion{reading.middle(), reason};
        begin(name, "reading.frozen", reason);
        reading.rejected.push_back({name, "frozen", std::move(reason)});
        writer_.add(RejectedAnswer{reading.device, reading.start, reading.sequence,
                                   reading.rejected.back()});
      }
    for (const auto& one : reading.rejected) {
      const bool is_needed =
          one.test != "missing" ||
          (device->length() && device->length()->channel.name() == one.channel) ||
          std::ranges::any_of(device->angles(), [&one](const auto& angle) {
            return angle.channel.name() == one.channel;
          });
      if (is_needed && !first) first = one.reason;
    }
  }
  if (!first) return {};
  return tl::unexpected(implausible(*first));
}

Result<void> Doubts::check_pose(const std::vector<ChannelValue>& pose,
                                const std::vector<double>& q_mm) {
  if (!datum_ || !geometry_.knows()) return {};
  const auto comparison = geometry_.compare(pose, motor_values(q_mm), datum_->values);
  if (!comparison.disagrees()) {
    end(kPose);
    return {};
  }
  const auto sentence = comparison.sentence();
  // Nearer to the zero the same error was within the limit.
  if (!suspicion_ && !standing_.contains(kPose)) suspicion_ = Suspicion{clock_.now().utc, sentence};
  begin(kPose, "pose.disagrees", sentence);
  return tl::unexpected(implausible(sentence));
}

bool Doubts::pose_is_at(const std::vector<ChannelValue>& pose,
                        const std::vector<double>& q_mm) const {
  if (!datum_ || !geometry_.knows()) return false;
  const auto comparison = geometry_.compare(pose, motor_values(q_mm), datum_->values);
  return !comparison.outputs.empty() && !comparison.disagrees();
}

bool Doubts::doubts_readback() const {
  const auto now = clock_.now().utc;
  return std::ranges::any_of(standing_, [now](const auto& one) {
    return (one.first == kPose || one.first == kReadback) &&
           seconds_from(now - one.second.last) < kForgotten_s;
  });
}

Result<void> Doubts::readback_is_off(const std::string& sentence) {
  begin(kReadback, "readback.disagrees", sentence);
  return tl::unexpected(implausible(sentence));
}

void Doubts::readback_is_good() { end(kReadback); }

Result<void> Doubts::check_zero(const std::vector<ChannelValue>& raw) {
  for (const auto& value : raw) {
    const auto lengths = cell_.length_channels();
    const auto is_it = [&value](const Channel& length) { return length.name() == value.channel; };
    const double off_nm = nm_from_mm(value.value);
    if (std::ranges::none_of(lengths, is_it) || std::abs(off_nm) <= cell_.plausibility.closure_nm)
      continue;
    auto sentence = fmt::format(
        "{} is {:+.0f} nm right after it was zeroed (limit {:g} nm, [plausibility] closure_nm): "
        "look at the interferometer",
        value.channel, off_nm, cell_.plausibility.closure_nm);
    begin(kZero, "zero.disagrees", sentence);
    return tl::unexpected(implausible(sentence));
  }
  end(kZero);
  return {};
}

void Doubts::begin_anew() {
  values_.begin_anew();
  standing_.clear();
}

std::vector<AlarmCondition> Doubts::conditions() const {
  std::vector<AlarmCondition> out;
  const auto now = clock_.now().utc;
  for (const auto& [subject, standing] : standing_)
    if (seconds_from(now - standing.last) < (standing.good_again ? kShown_s : kForgotten_s))
      out.push_back({AlarmLevel::failed, standing.kind, subject, standing.message});
  return out;
}

void Doubts::begin(const std::string& subject, const std::string& kind,
                   const std::string& message) {
  const auto now = clock_.now().utc;
  auto& standing = standing_[subject];
  const bool is_new = standing.kind != kind || seconds_from(now - standing.last) >= kForgotten_s;
  standing = {kind, message, now, false};
  if (!is_new) return;
  events_.record_own(kind, message);
  on_news_();
}

void Doubts::end(const std::string& subject) {
  const auto found = standing_.find(subject);
  if (found == standing_.end()) return;
  found->second.good_again = true;
  if (seconds_from(clock_.now().utc - found->second.last) < kShown_s) return;
  events_.record_own("reading.good_again", subject + " is plausible again");
  standing_.erase(found);
}

Error Doubts::implausible(const std::string& sentence) const {
  return {ErrorCode::failed_precondition, reasons::kImplausible, sentence};
}

// The other robots may move while this one's length stays.
std::vector<double> Doubts::of_robot(const std::vector<double>& q_mm,
                                     const std::string& symbol) const {
  std::vector<double> own_mm;
  const auto motors = cell_.motor_channels();
  for (std::size_t i = 0; i < std::min(motors.size(), q_mm.size()); ++i)
    if (robot_of(motors[i].symbol) == robot_of(symbol)) own_mm.push_back(q_mm[i]);
  return own_mm;
}

std::vector<ChannelValue> Doubts::motor_values(const std::vector<double>& q_mm) const {
  std::vector<ChannelValue> values;
  const auto channels = cell_.motor_channels();
  for (std::size_t i = 0; i < std::min(channels.size(), q_mm.size()); ++i)
    values.push_back({channels[i].name(), q_mm[i]});
  return values;
}

}  // namespace driftwise::application
