#include "server/diagnosis/diagnose.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>

#include "server/calibration/datum_zeros.h"
#include "server/core/data/unusable_values.h"
#include "server/core/try.h"
#include "server/diagnosis/answer/cancelled.h"
#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/data_faults.h"
#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/growth/held_out_gate.h"
#include "server/diagnosis/growth/held_out_mean.h"
#include "server/diagnosis/growth/left_over.h"
#include "server/diagnosis/growth/omnibus.h"
#include "server/diagnosis/noise/two_sides.h"
#include "server/diagnosis/path_of_turns.h"
#include "server/diagnosis/report/as_read.h"
#include "server/diagnosis/report/division.h"
#include "server/diagnosis/report/heading.h"
#include "server/diagnosis/report/left_unread.h"
#include "server/diagnosis/report/loose_terms.h"
#include "server/diagnosis/report/report.h"
#include "server/diagnosis/report/sentence.h"
#include "server/diagnosis/report/taken_by_time.h"
#include "server/diagnosis/rounded_outputs.h"
#include "server/diagnosis/rows/catalogue_units.h"
#include "server/diagnosis/rows/missing_values.h"
#include "server/diagnosis/rows/rows_needed.h"
#include "server/diagnosis/rows/screen.h"
#include "server/diagnosis/search/column_bank.h"
#include "server/diagnosis/stand_ins.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kWorthTelling = 0.2;  // adjusted p of what is not named
constexpr double kShareLeft = 0.35;    // of what a finding is named for

// How far it is: each look for one more cause takes a part of what is left of the way.
class Progress {
 public:
  explicit Progress(const DiagnoseOptions& options) : options_(options) {}
  bool at(double fraction, std::string step) {
    fraction_ = std::max(fraction_, fraction);
    step_ = std::move(step);
    return tick();
  }
  bool further(double share, std::string step) {
    return at(fraction_ + share * (1 - fraction_), std::move(step));
  }
  // Once it was told to stop, it stays stopped.
  bool tick() {
    if (!stopped_ && options_.progress) stopped_ = !options_.progress(fraction_, step_);
    return !stopped_;
  }

 private:
  const DiagnoseOptions& options_;
  bool stopped_ = false;
  double fraction_ = 0;
  std::string step_ = "reading the rows";
};

class Diagnoser {
 public:
  // readings: what the problem was laid out from.
  Diagnoser(const Dataset& dataset, const Dataset& readings, Problem problem,
            const DiagnoseOptions& options)
      : dataset_(dataset),
        readings_(readings),
        frame_(in_coordinates(problem)),
        problem_(frame_ ? frame_->problem : std::move(problem)),
        options_(options),
        progress_(options),
        faults_(dataset, options, problem_, result_) {}

  Result<Diagnosis> run(std::vector<FaultySensor> sensors) {
    result_.baseline_formula = options_.baseline.formula;
    if (!progress_.at(0.02, "looking at sensors and rows")) return cancelled();
    faults_.note_sensors(sensors);
    for (const auto& term : problem_.undetermined)
      result_.warnings.push_back(undetermined_note(problem_, term));
    faults_.leave_out_outliers();
    auto excluded = options_.exclude_symbols;
    const auto outputs = problem_.output_symbols();
    for (const auto& column : problem_.data().columns)
      if (is_response(column.channel, outputs)) excluded.push_back(column.channel.symbol);
    Dataset conditions = problem_.prepared.conditions();
    conditions.time_s = problem_.data().time_s;  // untimed data count their rows in there
    auto catalogue = catalogue_for(conditions, problem_.base, excluded);
    result_.not_testable = std::move(catalogue.not_testable);
    causes_ = std::move(catalogue.causes);
    while (true) {
      if (!progress_.at(0.04, "working out what each cause would do")) return cancelled();
      const Physics physics(problem_, options_.levers);
      DRIFTWISE_TRY(auto bank,
                    column_bank(problem_, physics, causes_, [this] { return progress_.tick(); }));
      series_ = problem_.searched();
      afresh_ = false;
      DRIFTWISE_RETURN_IF_ERROR(search(physics, std::move(bank)));
      if (!afresh_) break;
      // All over again: priors were weighed against a noise that had the sides or wrong rows in it.
    }
    if (!progress_.at(1, "describing the findings")) return cancelled();
    return std::move(result_);
  }

 private:
  SearchOptions search_options(std::uint64_t seed) {
    return {options_.nulls, options_.alpha, seed, options_.executor,
            [this] { return progress_.tick(); }};
  }

  Result<void> search(const Physics& physics, Bank bank) {
    Search search(problem_.timeline, series_, std::move(bank), search_options(options_.seed));
    Extension extension(problem_, causes_, series_, search, physics,
                        [this] { return progress_.tick(); });
    bool noise_looked_at = false;
    // What harms is forbidden and the search starts again without it: at most once per cause.
    for (std::size_t round = 0; round <= causes_.size(); ++round) {
      DRIFTWISE_RETURN_IF_ERROR(grow(search, extension, noise_looked_at, round > 0));
      if (afresh_) return {};
      if (!progress_.further(0.3, "comparing what was found with all others")) return cancelled();
      DRIFTWISE_TRY(auto said, extension.settle());
      result_.warnings.insert(result_.warnings.end(), said.begin(), said.end());
      if (!withdraw_harmful(extension)) break;
    }
    std::vector<std::string> refused = extension.refused();
    std::ranges::sort(refused);
    refused.erase(std::ranges::unique(refused).begin(), refused.end());
    result_.warnings.insert(result_.warnings.end(), refused.begin(), refused.end());
    // What is withdrawn there may leave what harms: the last word is the rows' that took no part.
    do {
      if (auto ok = look_at_remainder(physics, extension); !ok) return ok;
    } while (withdraw_harmful(extension));
    conclude(extension);
    return {};
  }

  bool withdraw_harmful(Extension& extension) {
    const auto harmful =
        withdraw_what_harms(problem_, causes_, frame_, extension, result_.warnings);
    for (const auto& one : harmful) {
      result_.warnings.push_back(one.sentence);
      extension.forbid(one.cause);
    }
    return !harmful.empty();
  }

  // again: after a withdrawal, against the nulls that were simulated before it.
  Result<void> grow(Search& search, Extension& extension, bool& noise_looked_at, bool again) {
    const bool first_round = !again;
    while (static_cast<int>(extension.named().size()) < options_.max_findings) {
      if (!progress_.further(0.3,
                             "looking for cause " + std::to_string(extension.named().size() + 1)))
        return cancelled();
      const auto look = again ? search.compare(extension.learned(), extension.allowed())
                              : search.look(extension.learned(), extension.allowed());
      if (!look) return cancelled();
      result_.nulls = std::max(result_.nulls, look->nulls);
      if (const auto sides = faults_.sides_beyond(*look, extension, series_)) {
        faults_.free_of_sides(*sides, extension.all());
        afresh_ = true;
        return {};
      }
      if (faults_.weighed_first(extension, *look)) {
        extension.weigh_again();
        again = false;
        continue;
      }
      if (look->first && look->p_adjusted <= options_.alpha) {
        DRIFTWISE_TRY(const auto added, extension.add(*look));
        again = !added;  // the base is the same one
        continue;
      }
      if (look->first) nearest_ = {name_of(causes_[*look->first]), look->p_adjusted};
      afresh_ = !noise_looked_at && faults_.leave_out_gross_errors(extension, look->shapes);
      if (afresh_) return {};
      if (!noise_looked_at && faults_.note_noise(extension, look->shapes)) {
        noise_looked_at = true;  // and look once more, with every row's own spread
        extension.weigh_again();
        again = false;
        continue;
      }
      if (faults_.tame_tails(extension, look->shapes)) {
        noise_looked_at = true;
        series_ = problem_.searched();
        again = false;
        continue;
      }
      if (!first_round || static_cast<int>(extension.named().size()) + 2 > options_.max_findings)
        break;
      DRIFTWISE_TRY(const bool two, extension.add_two(*look, options_.alpha));
      if (!two) break;
      again = false;
    }
    return {};
  }

  Result<void> look_at_remainder(const Physics& physics, Extension& extension) {
    if (!progress_.further(0.4, "looking at what is left")) return cancelled();
    Remainder remainder(with_all_rows_fitted(problem_, frame_), kMostSearched, physics,
                        options_.exclude_symbols, search_options(options_.seed + 1));
    Omnibus omnibus(remainder.whole(), remainder.series(), options_.exclude_symbols);
    while (true) {
      DRIFTWISE_TRY(const auto left, remainder.look(extension));
      if (const auto series = remainder.spelled_out(extension); !series.empty()) {
        std::string names;
        for (const std::size_t i : series)
          names += (names.empty() ? "" : " and ") + name_of(causes_[extension.named()[i].cause]);
        result_.warnings.push_back(names +
                                   (series.size() == 1 ? ": withdrawn, because it only spells"
                                                       : ": withdrawn, because they only spell") +
                                   " out a free shape that describes these data as well");
        for (std::size_t k = series.size(); k-- > 0;)
          DRIFTWISE_RETURN_IF_ERROR(extension.withdraw_with_its_train(series[k]));
        continue;
      }
      const auto test = omnibus.test(remainder.base(extension), omnibus_options());
      if (!test) return cancelled();
      result_.left_over.clear();
      if (left && left->p_adjusted <= options_.alpha) result_.left_over.push_back(*left);
      const bool in_shape = !result_.left_over.empty();
      if (test->p <= kOmnibusLevel) result_.left_over.push_back({test->where, test->p});
      if (result_.left_over.empty()) {
        tell_smallest(test->smallest);
        return {};
      }
      auto only_nearest = in_shape ? remainder.nearest_name(extension) : std::nullopt;
      if (!only_nearest && test->p <= kOmnibusLevel &&
          share_left_held_out(problem_, extension) > kShareLeft)
        only_nearest = poor(remainder, omnibus, extension);
      if (!only_nearest) return {};
      result_.warnings.push_back(
          name_of(causes_[extension.named()[*only_nearest].cause]) +
          " came nearest and was withdrawn: a good part of what it explains was left (" +
          result_.left_over.back().goes_with + ")");
      DRIFTWISE_RETURN_IF_ERROR(extension.withdraw_with_its_train(*only_nearest));
    }
  }

  // The finding that leaves the largest share of what it is named for. Not asked where the findings
  // together predict what they are named for on rows held out: a cause that is there has a real
  // shape which its ideal one leaves something of, and far above the noise that is seen.
  static std::optional<std::size_t> poor(const Remainder& remainder, const Omnibus& omnibus,
                                         const Extension& extension) {
    std::optional<std::size_t> worst;
    double most = kShareLeft;
    for (std::size_t i = 0; i < extension.named().size(); ++i) {
      const double share =
          omnibus.share_left(remainder.base(extension), remainder.base(extension, i));
      if (share <= most) continue;
      most = share;
      worst = i;
    }
    return worst;
  }

  // "adequate" says what it would have seen, shape by shape: "2.4 nm in q1, 2.3 nm in q2 of a
  // bump".
  void tell_smallest(const std::vector<SmallestSeen>& smallest) {
    std::string text;
    for (std::size_t i = 0; i < smallest.size(); ++i) {
      const SmallestSeen& one = smallest[i];
      const bool new_shape = i == 0 || smallest[i - 1].shape != one.shape;
      text += i == 0 ? "" : new_shape ? "; " : ", ";
      text += size_text(one.rms, one.unit) + " in " + one.output;
      if (i + 1 == smallest.size() || smallest[i + 1].shape != one.shape)
        text += " of " + one.shape;
    }
    if (!text.empty())
      result_.warnings.push_back(
          "what is left passed the test that knows no cause; in 80 % of cases it sees (rms) " +
          text);
  }

  OmnibusOptions omnibus_options() {
    return {kOmnibusLevel, std::max(options_.nulls, kOmnibusNulls), options_.seed + 2,
            [this] { return progress_.tick(); }};
  }

  void conclude(const Extension& extension) {
    auto findings = findings_of(problem_, causes_, extension, frame_);
    result_.findings.insert(result_.findings.end(), std::make_move_iterator(findings.begin()),
                            std::make_move_iterator(findings.end()));
    result_.extended_formula = extended_formula(result_.baseline_formula, result_.findings);
    result_.outputs = outputs_of(problem_, dataset_, extension, frame_);
    result_.rows_calibration = problem_.learn.size();
    result_.rows_held_out = problem_.judge.size();
    if (problem_.rows_per_block > 1)
      result_.warnings.push_back("the search worked on averages of " +
                                 std::to_string(problem_.rows_per_block) +
                                 " rows: what is faster than that was not looked for");
    if (nearest_.p_adjusted < kWorthTelling && nearest_.p_adjusted > options_.alpha) {
      char p_text[32];
      std::snprintf(p_text, sizeof p_text, "%.2g", nearest_.p_adjusted);
      result_.warnings.push_back("next would come " + nearest_.cause +
                                 ", which chance imitates too often to be named (adjusted p " +
                                 p_text + ")");
    }
    for (const auto& finding : result_.findings)
      for (const auto& note :
           {aliases_note(finding), follows_an_output_note(finding, problem_.output_symbols())})
        if (!note.empty()) result_.warnings.push_back(note);
    for (const auto& division : divisions_of(problem_, causes_, extension))
      result_.warnings.push_back(sentence(division));
    for (auto& said : thermal_causes_of_instruments(problem_, causes_, extension))
      result_.warnings.push_back(std::move(said));
    if (const auto loose = loose_terms(problem_)) result_.warnings.push_back(sentence(*loose));
    for (auto& said : worse_as_read(problem_, readings_))
      result_.warnings.push_back(std::move(said));
    result_.judged_on = problem_.judged_by_validation ? JudgedRows::validation : JudgedRows::blocks;
    for (auto& mean : means_beyond_noise(problem_, result_.outputs, extension, options_.alpha))
      result_.left_over.push_back(std::move(mean));
    for (auto& said : taken_by_time(result_)) result_.warnings.push_back(std::move(said));
    for (const auto& worse : outputs_made_worse(result_))
      result_.warnings.push_back("held-out A90 got worse with the findings: " + worse);
    if (problem_.judged_in_turn)
      result_.warnings.push_back(
          "there is no validation set: held-out figures are of ten blocks of time, each "
          "predicted from the others");
    else if (!problem_.judged_by_validation)
      result_.warnings.push_back(
          "there is no validation set: two of ten blocks of time were kept out to judge by");
    if (!result_.left_over.empty())
      result_.verdict = Verdict::unexplained;
    else
      result_.verdict = result_.findings.empty() ? Verdict::adequate : Verdict::extended;
  }

  const Dataset& dataset_;
  const Dataset& readings_;
  const std::optional<CoordinateFrame> frame_;  // nothing: the outputs are searched as they are
  Problem problem_;
  const DiagnoseOptions& options_;
  Progress progress_;
  std::vector<Cause> causes_;
  Eigen::MatrixXd series_;
  bool afresh_ = false;  // the search starts again: readings on two sides, wrong rows
  struct {
    std::string cause;
    double p_adjusted = 1;
  } nearest_;  // of those that were not named
  Diagnosis result_;
  DataFaults faults_;
};

// Symbols of the channels that are conditions: no pose, no motor and no response.
std::vector<std::string> conditions_of(const Dataset& dataset,
                                       const std::vector<std::string>& outputs) {
  std::vector<std::string> conditions;
  for (const auto& column : dataset.columns)
    if (const Channel& channel = column.channel; !is_pose_symbol(channel.symbol) &&
                                                 !is_motor_symbol(channel.symbol) &&
                                                 !is_response(channel, outputs))
      conditions.push_back(channel.symbol);
  return conditions;
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::adequate:
      return "adequate";
    case Verdict::extended:
      return "extended";
    case Verdict::unexplained:
      return "unexplained";
  }
  return "";
}

Result<Diagnosis> diagnose(const Dataset& dataset, const DiagnoseOptions& options) {
  if (const auto usable = without_unusable(dataset)) {
    auto found = diagnose(usable->data, options);
    if (found) found->warnings.insert(found->warnings.begin(), usable->sentence);
    return found;
  }
  auto strays = deviations_of(dataset, options.baseline);
  std::erase_if(strays, [&](const std::string& symbol) {
    return std::ranges::find(options.exclude_symbols, symbol) != options.exclude_symbols.end();
  });
  if (!strays.empty()) {
    DiagnoseOptions without = options;
    without.exclude_symbols.insert(without.exclude_symbols.end(), strays.begin(), strays.end());
    return diagnose(dataset, without);
  }
  if (options.simulated.size() == 0)
    if (const auto with = stand_ins(dataset, options)) {
      auto found = diagnose(with->data, with->options);
      if (found) name_as_in_file(*with, *found);
      return found;
    }
  bool is_stopped = false;
  const auto tick = [&] {
    is_stopped = is_stopped || (options.progress && !options.progress(0, "reading the rows"));
    return !is_stopped;
  };
  if (!tick()) return cancelled();
  auto whole =
      without_gaps(in_catalogue_units(dataset), conditions_of(dataset, options.baseline.outputs));
  Dataset& mended = whole.data;
  const auto laid = [&](const Dataset& data) -> std::optional<Problem> {
    if (!tick()) return std::nullopt;
    auto problem = lay_out(data, options.baseline, kMostSearched);
    return problem ? std::optional(std::move(*problem)) : std::nullopt;
  };
  auto sensors = mend_sensors(mended, options.baseline.outputs.size(), options.alpha,
                              likelihood_of(laid), tick);
  if (is_stopped) return cancelled();
  DiagnoseOptions asked = options;
  auto living = without_dead_sensors(options.baseline, dataset, sensors);
  close_gaps_of(sensors, living, whole);
  asked.baseline = std::move(living.baseline);
  asked.exclude_symbols.insert(asked.exclude_symbols.end(), living.dead.begin(), living.dead.end());
  asked.exclude_symbols.insert(asked.exclude_symbols.end(), whole.unread.begin(),
                               whole.unread.end());
  const bool one_datum =
      std::ranges::adjacent_find(mended.datum, std::not_equal_to{}) == mended.datum.end();
  if (options.simulated.size() == 0 && !one_datum) {
    // As a fit has further datums (docs/decisions/0005): a constant alone would leave a slope where
    // the geometry is curved, and some cause would be found for it.
    calibration::FitOptions fit;
    fit.candidates = in_catalogue_units(asked.baseline);
    fit.candidates.constant = true;
    mended = calibration::in_first_datum(mended, calibration::find_datum_zeros(mended, fit));
  }
  // What was simulated was identified without two of ten blocks (robot_diagnosis.cc): no other rows
  // are unseen.
  const auto judging = options.simulated.size() > 0 ? Judging::apart : Judging::in_turn;
  DRIFTWISE_TRY(auto problem,
                lay_out_on_path(mended, asked, kMostSearched, judging, whole.sentences));
  if (options.simulated.size() > 0)
    for (std::size_t o = 0; o < problem.outputs.size(); ++o)
      problem.outputs[o].measured -=
          summary_unit(dataset.find(problem.outputs[o].channel.symbol)->channel.unit).factor *
          options.simulated.col(static_cast<Eigen::Index>(o));
  for (auto& said : rows_left_out(problem)) whole.sentences.push_back(std::move(said));
  for (auto& said : coarse_notes(problem.prepared.coarse()))
    whole.sentences.push_back(std::move(said));
  // By the baseline alone, then by what is found: rounding errors are no simulation behind them.
  Problem freed = problem;
  DRIFTWISE_TRY(auto rounded, free_of_rounding(freed, dataset, {}));
  auto found = Diagnoser(dataset, mended, std::move(freed), asked).run(sensors);
  if (!found) return found;
  const auto adds = [](const Finding& finding) { return !finding.terms.empty(); };
  DRIFTWISE_TRY(auto again, free_of_rounding(problem, dataset, found->findings));
  if (!again.empty() && (rounded.empty() || std::ranges::any_of(found->findings, adds))) {
    rounded = std::move(again);
    found = Diagnoser(dataset, mended, std::move(problem), asked).run(std::move(sensors));
    if (!found) return found;
  }
  whole.sentences.insert(whole.sentences.end(), rounded.begin(), rounded.end());
  for (auto& said : unread_coordinates(dataset, options))
    whole.sentences.push_back(std::move(said));
  if (!dataset.set.empty() && std::ranges::count(dataset.set, PointSet::calibration) == 0)
    whole.sentences.push_back(
        "every row is marked for validation: they are what the search learns from, and nothing "
        "judges it that it has not seen");
  found->warnings.insert(found->warnings.begin(), whole.sentences.begin(), whole.sentences.end());
  for (auto& finding : found->findings)
    for (auto& output : finding.outputs)
      for (std::size_t k = 0; k < output.coefficients.size() && k < finding.terms.size(); ++k)
        output.coefficients[k] *= coefficient_factor(dataset, finding.terms[k], output.output);
  return found;
}

}  // namespace driftwise::diagnosis
