// What the setters of the GCS emulator do, and how their arguments are read.

#include <algorithm>
#include <set>

#include "drivers/simulated/emulators/pi_gcs/pi_gcs_emulator.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {

void PiGcsEmulator::move(Words words, bool relative, TimeNs now) {
  auto wanted = pairs(words);
  if (!wanted) return;
  for (auto& [axis, mm] : *wanted) {
    const auto i = static_cast<std::size_t>(axis);
    if (!servo_[i] || !axis_state(axis, now).referenced) {
      error(5);
      return;
    }
    if (relative) mm += target_mm_[i];
    const AxisTravel travel = axis_travel(axis);
    if (mm < travel.min_mm || mm > travel.max_mm) {
      error(7);
      return;
    }
  }
  for (const auto& [axis, mm] : *wanted) target_mm_[static_cast<std::size_t>(axis)] = mm;
  // A second MOV before the first has started: both targets start together, the newer one wins per
  // axis.
  std::vector<Pair> targets;
  if (pending_) {
    timeline_.cancel(pending_->event);
    targets = std::move(pending_->targets);
  }
  targets.insert(targets.end(), wanted->begin(), wanted->end());
  const auto event = timeline_.at(now + start_delay_, [this](TimeNs start) {
    const auto started = std::move(pending_->targets);
    pending_.reset();
    std::set<int> done;
    for (auto pair = started.rbegin(); pair != started.rend(); ++pair)
      if (done.insert(pair->axis).second)
        plant_.start_move(first_axis_ + pair->axis, pair->value, start);
  });
  if (targets.size() > 64) targets.erase(targets.begin());  // a client that only ever types MOV
  pending_ = PendingStart{event, std::move(targets)};
}

void PiGcsEmulator::set_servo(Words words, TimeNs now) {
  const auto wanted = pairs(words);
  if (!wanted) return;
  for (const auto& [axis, value] : *wanted)
    if (value != 0 && value != 1) {
      error(17);
      return;
    }
  for (const auto& [axis, value] : *wanted) {
    servo_[static_cast<std::size_t>(axis)] = value == 1;
    plant_.set_servo(first_axis_ + axis, value == 1, now);
  }
}

void PiGcsEmulator::reference(Words words, TimeNs now) {
  const auto wanted = axes(words);
  if (!wanted) return;
  for (const int axis : *wanted)
    if (!servo_[static_cast<std::size_t>(axis)]) {
      error(5);
      return;
    }
  for (const int axis : *wanted) {
    target_mm_[static_cast<std::size_t>(axis)] = 0.0;
    plant_.start_reference(first_axis_ + axis, now);
  }
}

void PiGcsEmulator::set_velocity(Words words, bool system, TimeNs now) {
  std::vector<Pair> wanted;
  if (system) {
    if (words.size() != 1) {
      error(words.empty() ? 26 : 24);
      return;
    }
    const auto value = parse_number(words[0]);
    if (!value) {
      error(1);
      return;
    }
    for (int axis = 0; axis < axis_count(); ++axis) wanted.push_back({axis, *value});
  } else {
    auto named = pairs(words);
    if (!named) return;
    wanted = std::move(*named);
  }
  for (const auto& [axis, mm_s] : wanted)
    if (!(mm_s > 0) || mm_s > max_velocity_) {
      error(8);
      return;
    }
  for (const auto& [axis, mm_s] : wanted) {
    velocity_mm_s_[static_cast<std::size_t>(axis)] = mm_s;
    plant_.set_velocity(first_axis_ + axis, mm_s, now);
  }
}

void PiGcsEmulator::halt(TimeNs now) {
  if (pending_) timeline_.cancel(pending_->event);
  pending_.reset();
  for (int axis = 0; axis < axis_count(); ++axis) plant_.halt_axis(first_axis_ + axis, now);
  for (int axis = 0; axis < axis_count(); ++axis)
    target_mm_[static_cast<std::size_t>(axis)] = axis_state(axis, now).q_mm;
  error(10);
}

int PiGcsEmulator::error(int number) {
  if (!keep_first_error_ || error_ == 0) error_ = number;
  return number;
}

std::optional<int> PiGcsEmulator::axis_index(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), upper(name));
  if (found == names_.end()) return std::nullopt;
  return static_cast<int>(found - names_.begin());
}

std::optional<std::vector<int>> PiGcsEmulator::axes(Words words) {
  std::vector<int> out;
  for (const auto word : words) {
    const auto axis = axis_index(word);
    if (!axis) {
      error(15);
      return std::nullopt;
    }
    out.push_back(*axis);
  }
  if (words.empty())
    for (int axis = 0; axis < axis_count(); ++axis) out.push_back(axis);
  return out;
}

std::optional<std::vector<PiGcsEmulator::Pair>> PiGcsEmulator::pairs(Words words) {
  std::vector<Pair> out;
  for (std::size_t i = 0; i < words.size(); i += 2) {
    const auto axis = axis_index(words[i]);
    const bool has_value = i + 1 < words.size();
    const auto value = has_value ? parse_number(words[i + 1]) : std::nullopt;
    if (!axis || !value) {
      error(!axis ? 15 : !has_value ? 26 : 1);
      return std::nullopt;
    }
    out.push_back({*axis, *value});
  }
  if (words.empty()) {
    error(26);
    return std::nullopt;
  }
  if (words.size() > 2 * names_.size()) {
    error(24);
    return std::nullopt;
  }
  return out;
}

bool PiGcsEmulator::all_referenced(TimeNs now) {
  for (int axis = 0; axis < axis_count(); ++axis)
    if (!axis_state(axis, now).referenced) return false;
  return true;
}

bool PiGcsEmulator::any_referencing(TimeNs now) {
  for (int axis = 0; axis < axis_count(); ++axis)
    if (axis_state(axis, now).referencing) return true;
  return false;
}

void PiGcsEmulator::reply(Session session, std::string text, TimeNs now) {
  timeline_.at(now + latency_, [this, session, bytes = std::move(text)](TimeNs due) {
    if (input_.contains(session)) send(session, bytes, due);
  });
}

}  // namespace driftwise::simulated
