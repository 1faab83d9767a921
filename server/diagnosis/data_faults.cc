#include "server/diagnosis/data_faults.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "server/diagnosis/growth/omnibus.h"
#include "server/diagnosis/noise/own_rows.h"
#include "server/diagnosis/noise/tails.h"
#include "server/diagnosis/report/report.h"
#include "server/diagnosis/report/sentence.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/diagnosis/search/column_bank.h"

namespace driftwise::diagnosis {
namespace {

// Growth of 2 ln L by the changes, less the choice among the instants.
double gain_of(const std::vector<NoiseChange>& changes, Eigen::Index instants) {
  double sum = changes.empty() ? 0 : -2 * std::log(static_cast<double>(instants));
  for (const auto& change : changes) sum += change.gain;
  return sum;
}

constexpr double kMostFreedom = 6;  // of tails that are worth it: a sixth of the noise's variance

}  // namespace

void DataFaults::note_sensors(const std::vector<FaultySensor>& sensors) {
  for (const auto& sensor : sensors) {
    const std::size_t first = sensor.rows.front();
    const std::string said = sentence(sensor, options_.name_of_row(first));
    // One or two wrong readings are left out and said; they explain nothing.
    if ((sensor.fault == SensorFault::spiked && sensor.rows.size() < 3) || !sensor.named) {
      result_.warnings.push_back(said);
      continue;
    }
    Finding finding{.cause = "sensor_fault",
                    .subject = sensor.channel,
                    .where = "sensor",
                    .applies_to = effects::AppliesTo::dataset,
                    .rows = sensor.rows,
                    .p_adjusted = std::max(sensor.p, kSmallestP),
                    .sentence = said};
    if (!dataset_.time_s.empty())
      finding.parameters.push_back({"time_s", dataset_.time_s[first], {}, {}});
    result_.findings.push_back(std::move(finding));
  }
}

void DataFaults::leave_out_outliers() {
  const auto outliers = outlier_rows(problem_, options_.alpha);
  if (outliers.empty()) return;
  problem_.leave_out(note_outliers(outliers));
  problem_.lay_blocks(kMostSearched);
}

std::vector<std::size_t> DataFaults::note_outliers(const std::vector<OutlierRow>& outliers) {
  std::vector<std::size_t> rows;
  for (const auto& one : outliers)
    if (rows.empty() || rows.back() != one.row) rows.push_back(one.row);
  auto known = std::ranges::find(result_.findings, "outliers", &Finding::cause);
  if (known == result_.findings.end())
    known = result_.findings.insert(
        known,
        Finding{.cause = "outliers", .where = "data", .applies_to = effects::AppliesTo::dataset});
  for (const auto& one : outliers)
    known->p_adjusted = std::min(known->p_adjusted, std::max(one.p, kSmallestP));
  known->rows.insert(known->rows.end(), rows.begin(), rows.end());
  std::ranges::sort(known->rows);
  known->parameters = {{"count", static_cast<double>(known->rows.size()), {}, {}}};
  known->sentence = sentence(*known);
  return rows;
}

bool DataFaults::leave_out_gross_errors(const Extension& extension,
                                        const std::vector<NoiseShape>& shapes) {
  const auto gross = gross_errors(problem_, extension.ground({}, shapes), options_.alpha);
  if (gross.empty()) return false;
  problem_.leave_out(note_outliers(gross));
  problem_.lay_blocks(kMostSearched);
  return true;
}

bool DataFaults::is_structure(const std::vector<NoiseChange>& changes,
                              const SoftBase& simulation) const {
  double largest = 0, together = 0;
  for (const auto& change : changes) {
    largest = std::max(largest, change.gain);
    together += change.gain;
  }
  return is_structure(largest, together, simulation);
}

bool DataFaults::is_structure(double of_one, double of_all, const SoftBase& simulation) const {
  const Eigen::MatrixXd series = problem_.series();
  const auto field =
      Omnibus(problem_, series, options_.exclude_symbols).likeliest_field(simulation);
  return field.of_one > of_one || field.of_all > of_all;
}

bool DataFaults::note_noise(const Extension& extension, const std::vector<NoiseShape>& shapes) {
  bool any = false;
  // A spread that goes with the place and one that changes at an instant imitate one another: the
  // one that explains more is taken first, and the other is asked of what is left.
  const auto weighed_by_place = [&](double than) {
    const auto spread = spread_over_places(problem_, extension.ground({}, shapes));
    if (!spread || spread->gain <= than) return false;
    weigh_rows(*spread, "place");
    return any = true;
  };
  auto changes = noise_changes(extension.ground({}, shapes));
  const bool place_first = weighed_by_place(gain_of(changes, problem_.timeline.rows()));
  if (place_first) changes = noise_changes(extension.ground({}, shapes));
  if (!changes.empty() && !is_structure(changes, extension.learned())) {
    note_changes(changes);
    any = true;
  }
  if (!place_first) weighed_by_place(0);
  return any;
}

void DataFaults::note_changes(const std::vector<NoiseChange>& changes) {
  const auto rows = static_cast<Eigen::Index>(problem_.data().rows);
  for (const auto& change : changes) {
    const auto& output = problem_.outputs[change.output];
    Finding finding{.cause = "noise_change",
                    .subject = output.channel.symbol,
                    .where = "data",
                    .applies_to = effects::AppliesTo::dataset,
                    .p_adjusted = std::max(std::exp(-change.together / 2), kSmallestP),
                    .log_likelihood_ratio = change.gain / 2};
    finding.parameters.push_back({"ratio", change.ratio, {}, {}});
    finding.parameters.push_back({"time_s", problem_.timeline.time_s[change.block], {}, {}});
    finding.sentence = sentence(finding);
    result_.findings.push_back(std::move(finding));
    const auto first = static_cast<Eigen::Index>(problem_.learn[static_cast<std::size_t>(
        std::ranges::find(problem_.block_of, static_cast<std::size_t>(change.block)) -
        problem_.block_of.begin())]);
    Eigen::VectorXd sd = Eigen::VectorXd::Ones(rows);
    sd.tail(rows - first).setConstant(change.ratio);
    problem_.spread_rows(sd, change.output);
  }
  problem_.lay_blocks(kMostSearched);
}

void DataFaults::weigh_rows(const Spread& spread, const std::string& goes_with) {
  std::string of;
  for (const std::size_t o : spread.outputs) {
    problem_.spread_rows(spread.sd.col(static_cast<Eigen::Index>(o)), o);
    of += (of.empty() ? " of " : ", ") + problem_.outputs[o].channel.symbol;
  }
  problem_.lay_blocks(kMostSearched);
  if (spread.outputs.size() == problem_.outputs.size()) of.clear();
  // Weighed by the same again, as what was found leaves it: said once, of both together.
  Eigen::MatrixXd& together = spreads_[goes_with + of];
  together = together.size() == 0 ? spread.sd : Eigen::MatrixXd(together.cwiseProduct(spread.sd));
  const Eigen::MatrixXd learned = rows_of(together, problem_.learn);
  const std::string begin = "the noise" + of + " goes with the " + goes_with + ": ";
  std::erase_if(result_.warnings, [&](const std::string& said) { return said.starts_with(begin); });
  char ratio[32];
  std::snprintf(
      ratio, sizeof ratio, "%.2g",
      learned.colwise().maxCoeff().cwiseQuotient(learned.colwise().minCoeff()).maxCoeff());
  result_.warnings.push_back(begin + ratio +
                             " times as large at its largest as at its smallest; every row counts "
                             "by its own");
}

bool DataFaults::weighed_first(const Extension& extension, const Look& look) {
  const Ground ground = extension.ground({}, look.shapes);
  const double cause =
      look.first && look.p_adjusted <= options_.alpha ? look.causes[*look.first].evidence : 0;
  const double at_an_instant = gain_of(noise_changes(ground), problem_.timeline.rows());
  const auto over_time = time_weighed_ ? std::nullopt : spread_over_time(problem_, ground);
  const auto over_places = place_weighed_ ? std::nullopt : spread_over_places(problem_, ground);
  const auto more = [](const std::optional<Spread>& one, double than) {
    return one && one->gain > than;
  };
  if (more(over_time, std::max({cause, at_an_instant, over_places ? over_places->gain : 0}))) {
    time_weighed_ = true;
    weigh_rows(*over_time, "hour");
    return true;
  }
  if (!more(over_places, std::max(cause, at_an_instant))) return false;
  place_weighed_ = true;
  weigh_rows(*over_places, "place");
  return true;
}

bool DataFaults::tame_tails(const Extension& extension, const std::vector<NoiseShape>& shapes) {
  if (tamed_ || problem_.rows_per_block > 1) return false;
  const Ground ground = extension.ground({}, shapes);
  std::vector<OwnRows> own;
  std::vector<Tails> tails;
  for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
    const WhitenedSpace& space = ground.space(ground.best_shape(o), o);
    own.push_back(own_rows(space, space.left_over(ground.series().col(o))));
    tails.emplace_back(own.back().off.col(0));
  }
  const CommonTails common = common_tails(tails);
  const double freedom = Tails::kFreedoms[common.freedom];
  if (common.gain < 2 * std::log(1 / options_.alpha) || freedom > kMostFreedom) return false;
  if (is_structure(common.gain, common.gain, extension.learned())) return false;
  tamed_ = true;
  for (std::size_t o = 0; o < problem_.outputs.size(); ++o) {
    const Eigen::ArrayXd off = own[o].off.col(0);
    // The law's score over its mean slope, (freedom + 1) / (freedom + 3) of its value at zero.
    const Eigen::ArrayXd said =
        off * (freedom + 3) / (freedom + off.square() / tails[o].square(common.freedom));
    auto& output = problem_.outputs[o];
    output.tails = Eigen::VectorXd::Zero(output.measured.size());
    for (std::size_t i = 0; i < problem_.learn.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      if (own[o].length[at] > 0)
        output.tails[static_cast<Eigen::Index>(problem_.learn[i])] =
            (off[at] - said[at]) / own[o].length[at];
    }
  }
  char text[200];
  std::snprintf(text, sizeof text,
                "the noise has heavy tails (Student's law with %.0f degrees of freedom): the "
                "search takes every row for what it says under that law",
                freedom);
  result_.warnings.emplace_back(text);
  return true;
}

Eigen::MatrixXd DataFaults::channels() const {
  const auto outputs = problem_.output_symbols();
  const Eigen::Index rows = problem_.timeline.rows();
  std::vector<Eigen::VectorXd> found = {Eigen::VectorXd::LinSpaced(rows, 0, 1)};
  for (const auto& [channel, values] : problem_.prepared.conditions().columns) {
    if (is_response(channel, outputs)) continue;
    const Eigen::VectorXd learned = problem_.learned(
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
    if (learned.allFinite() && learned.maxCoeff() > learned.minCoeff()) found.push_back(learned);
  }
  Eigen::MatrixXd result(rows, static_cast<Eigen::Index>(found.size()));
  for (std::size_t k = 0; k < found.size(); ++k)
    result.col(static_cast<Eigen::Index>(k)) = found[k];
  return result;
}

std::optional<TwoSides> DataFaults::sides_beyond(const Look& look, const Extension& extension,
                                                 const Eigen::MatrixXd& series) const {
  if (problem_.rows_per_block > 1 || problem_.outputs.front().freed_of.size() > 0) return {};
  auto sides = two_sides(problem_.timeline, extension.learned(), series, channels());
  const double best = look.first ? look.causes[*look.first].evidence : 0;
  const double by_chance = 2 * std::log(static_cast<double>(series.cols()) / options_.alpha);
  if (!sides || sides->gain < by_chance || sides->evidence < best) return std::nullopt;
  return sides;
}

void DataFaults::free_of_sides(const TwoSides& sides, const SoftBase& simulation) {
  const auto rows = static_cast<Eigen::Index>(problem_.data().rows);
  Eigen::VectorXd side = Eigen::VectorXd::Zero(rows);
  for (std::size_t i = 0; i < problem_.learn.size(); ++i)
    side[static_cast<Eigen::Index>(problem_.learn[i])] = sides.side[static_cast<Eigen::Index>(i)];
  const auto take_out = [&] {
    for (std::size_t o = 0; o < problem_.outputs.size(); ++o) {
      auto& output = problem_.outputs[o];
      if (output.freed_of.size() > 0) output.measured += output.freed_of;
      output.freed_of = side * sides.half[static_cast<Eigen::Index>(o)];
      output.measured -= output.freed_of;
    }
  };
  take_out();
  // Rows that did not learn lie on the side that is nearer to what the others foretell.
  Eigen::VectorXd shows = Eigen::VectorXd::Zero(rows);
  for (std::size_t o = 0; o < problem_.outputs.size(); ++o)
    shows += residuals(problem_, problem_.outputs[o], simulation) *
             sides.along[static_cast<Eigen::Index>(o)];
  const double way = sides.half.dot(sides.along);
  for (const std::size_t row : problem_.judge)
    if (auto& one = side[static_cast<Eigen::Index>(row)]; one == 0)
      one = shows[static_cast<Eigen::Index>(row)] * way < 0 ? -1 : 1;
  take_out();
  result_.findings.push_back(probe_hysteresis(problem_, sides));
  result_.warnings.push_back(
      "the sides of " + result_.findings.back().subject +
      " are taken out of what the search looks at, and stay in the figures: no "
      "model predicts them. Approach every point from the same side, from further than the "
      "width, or read it with an instrument that nothing rubs on");
}

}  // namespace driftwise::diagnosis
