#include "server/diagnosis/check/check_memory.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "server/core/try.h"
#include "server/effects/term_evaluator.h"
#include "server/effects/time_constant.h"

namespace driftwise::diagnosis {
namespace {

bool remembers(const effects::Call& call) {
  return effects::tau_s(call) > 0 &&
         std::ranges::none_of(call.symbols, [](const std::string& symbol) {
           return is_pose_symbol(symbol) || is_motor_symbol(symbol) || symbol == "dwell";
         });
}

template <class Visit>
void each_memory(const calibration::Model& model, Visit visit) {
  for (const auto& output : model.outputs)
    for (const auto& term : output.terms)
      for (const auto& factor : term.factors)
        if (const auto* call = std::get_if<effects::Call>(&factor); call && remembers(*call))
          visit(*call);
}

Channel channel_of_call(const effects::Call& call) {
  return {effects::notation(effects::Term{{call}}), "1"};
}

// Values of one effect at the rows and zeros of a run.
class Replay {
 public:
  Replay(const effects::Call& call, effects::TermEvaluator evaluator, const RunToCheck& run)
      : tau_s_(effects::tau_s(call)), evaluator_(std::move(evaluator)), run_(run) {
    for (const auto& symbol : call.symbols) columns_.push_back(run.data.find(symbol));
    latest_.assign(call.symbols.size(), kMissing);
  }

  // Everything in order of time: readings, then a zero, then the row of the same instant.
  void play() {
    std::size_t reading = 0;
    std::vector<char> zeroed(run_.zeros.size(), 0);
    zeros.assign(run_.zeros.size(), kMissing);
    for (std::size_t row = 0; row < run_.data.rows; ++row) {
      const double now_s = run_.data.time_s[row];
      for (; reading < run_.before.size() && run_.before[reading].time_s <= now_s; ++reading) {
        play_zeros(run_.before[reading].time_s, zeroed);
        see(run_.before[reading].values);
        const bool until_here = unsettled;
        step(run_.before[reading].time_s);
        unsettled = until_here;  // of rows and zeros alone
      }
      play_zeros(now_s, zeroed);
      for (std::size_t i = 0; i < columns_.size(); ++i) latest_[i] = columns_[i]->values[row];
      rows.push_back(step(now_s));
    }
  }

  std::vector<double> rows, zeros;
  std::optional<double> began_s;  // first instant with every channel
  bool unsettled = false;         // some row or zero comes too soon after it

 private:
  void play_zeros(double until_s, std::vector<char>& zeroed) {
    for (std::size_t k = 0; k < zeroed.size() && k < run_.zero_times_s.size(); ++k) {
      if (zeroed[k] || !(run_.zero_times_s[k] <= until_s)) continue;
      zeroed[k] = 1;
      see(run_.zeros[k]);
      zeros[k] = step(run_.zero_times_s[k]);
    }
  }

  void see(const std::vector<ChannelValue>& values) {
    for (std::size_t i = 0; i < columns_.size(); ++i)
      for (const auto& value : values)
        if (value.channel == columns_[i]->channel.name() && !is_missing(value.value))
          latest_[i] = value.value;
  }

  double step(double time_s) {
    double value = kMissing;
    evaluator_.step(time_s, latest_, std::span(&value, 1));
    if (is_missing(value)) return value;
    if (!began_s) began_s = time_s;
    if (time_s - *began_s >= effects::kKnownTaus * tau_s_) return value;
    unsettled = true;
    return kMissing;
  }

  double tau_s_;
  effects::TermEvaluator evaluator_;
  const RunToCheck& run_;
  std::vector<const DatasetColumn*> columns_;
  std::vector<double> latest_;
};

std::string sentence_of(const effects::Call& call, double read_s) {
  char text[320];
  std::snprintf(text, sizeof text,
                "%s needs readings of %.1f h, and they begin %.1f h before the first row",
                channel_of_call(call).symbol.c_str(),
                effects::kKnownTaus * effects::tau_s(call) / 3600, read_s / 3600);
  return text;
}

}  // namespace

ModelMemory memory_of(const calibration::Model& model) {
  ModelMemory memory;
  each_memory(model, [&](const effects::Call& call) {
    memory.longest_tau_s = std::max(memory.longest_tau_s, effects::tau_s(call));
    for (const auto& symbol : call.symbols)
      if (std::ranges::find(memory.symbols, symbol) == memory.symbols.end())
        memory.symbols.push_back(symbol);
  });
  return memory;
}

calibration::Model with_effects_as_channels(calibration::Model model) {
  for (auto& output : model.outputs)
    for (auto& term : output.terms)
      for (auto& factor : term.factors)
        if (const auto* call = std::get_if<effects::Call>(&factor); call && remembers(*call))
          factor = effects::Power{channel_of_call(*call).symbol};
  return model;
}

RunToCheck with_effects_as_channels(const calibration::Model& model, RunToCheck run) {
  if (run.data.time_s.size() != run.data.rows || run.data.rows == 0) return run;
  std::vector<effects::Call> calls;
  each_memory(model, [&](const effects::Call& call) {
    if (std::ranges::find(calls, call) == calls.end()) calls.push_back(call);
  });
  for (const auto& call : calls) {
    auto evaluator = effects::TermEvaluator::create({effects::Term{{call}}}, call.symbols);
    const bool has_all = std::ranges::all_of(
        call.symbols, [&](const std::string& symbol) { return run.data.find(symbol) != nullptr; });
    if (!evaluator || !has_all) continue;  // the check then names the channel that is not there
    Replay replay(call, std::move(*evaluator), run);
    replay.play();
    if (replay.unsettled && run.unknown_memory.empty())
      run.unknown_memory =
          sentence_of(call, std::max(0.0, run.data.time_s.front() - *replay.began_s));
    const Channel channel = channel_of_call(call);
    for (std::size_t k = 0; k < run.zeros.size(); ++k)
      run.zeros[k].push_back({channel.name(), replay.zeros[k]});
    run.data.columns.push_back({channel, std::move(replay.rows)});
  }
  return run;
}

Result<RunToCheck> as_the_model_reads(const calibration::Model& model, RunToCheck run) {
  DRIFTWISE_TRY(auto in_units, in_model_units(model, std::move(run)));
  return in_model_datum(with_effects_as_channels(model),
                        with_effects_as_channels(model, std::move(in_units)));
}

}  // namespace driftwise::diagnosis
