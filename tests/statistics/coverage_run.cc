#include "tests/statistics/coverage_run.h"

#include <cmath>
#include <cstdio>
#include <exception>
#include <mutex>
#include <thread>

namespace driftwise::statistics {
namespace {

// A normal error that u states rightly: the mean of |error| / u.
constexpr double kMeanOfNormal = 0.798;

void add_by_lead(const Served& served, std::size_t output, bool every, CoverageOfOutput& sum) {
  for (auto& lead : sum.by_lead) {
    std::int64_t hits = 0, targets = 0;
    for (const auto& outcome : served.outcomes) {
      if (!outcome.inside_domain || (!every && outcome.output != output) ||
          outcome.since_zero_h < lead.from_h || outcome.since_zero_h >= lead.to_h)
        continue;
      const double ratio = std::abs(outcome.error_nm) / outcome.u_nm;
      ++targets;
      hits += ratio <= 2 ? 1 : 0;
      lead.ratios += ratio;
      lead.squares += ratio * ratio;
    }
    lead.inside.add_campaign(hits, targets);
  }
}

void add_campaign(const Served& served, std::vector<CoverageOfOutput>& sums) {
  if (sums.empty()) {
    for (const auto& output : served.model.outputs) {
      sums.emplace_back();
      sums.back().channel = output.channel.name();
    }
    sums.emplace_back();
    sums.back().channel = "all";
  }
  std::vector<std::int64_t> hits(sums.size()), targets(sums.size());
  auto& all = sums.back();
  for (const auto& outcome : served.outcomes) {
    auto& sum = sums[outcome.output];
    if (!outcome.inside_domain) {
      ++sum.outside, ++all.outside;
      continue;
    }
    ++targets[outcome.output];
    if (std::abs(outcome.error_nm) <= 2 * outcome.u_nm) ++hits[outcome.output];
    sum.squares += std::pow(outcome.error_nm / outcome.u_nm, 2);
    sum.error_nm2 += outcome.error_nm * outcome.error_nm;
    all.squares += std::pow(outcome.error_nm / outcome.u_nm, 2);
    all.error_nm2 += outcome.error_nm * outcome.error_nm;
    for (std::size_t i = 0; i < outcome.budget.lines; ++i) {
      const auto& line = outcome.budget.line[i];
      sum.line_nm2[static_cast<std::size_t>(line.source)] += line.u_nm * line.u_nm;
    }
  }
  std::int64_t all_hits = 0, all_targets = 0;
  for (std::size_t o = 0; o + 1 < sums.size(); ++o) {
    sums[o].inside.add_campaign(hits[o], targets[o]);
    all_hits += hits[o];
    all_targets += targets[o];
  }
  sums.back().inside.add_campaign(all_hits, all_targets);
  for (std::size_t o = 0; o < sums.size(); ++o)
    add_by_lead(served, o, o + 1 == sums.size(), sums[o]);
}

std::string table_by_lead(const CoverageOfOutput& output) {
  char line[200];
  std::snprintf(line, sizeof line,
                "%s by hours since the zero (a normal error of the size that is stated: mean %.2f, "
                "rms 1):\n"
                "  since zero  campaigns  targets   within 2u  95 %% by campaign  mean |error|/u  "
                "rms error/u\n",
                output.channel.c_str(), kMeanOfNormal);
  std::string out = line;
  for (const auto& lead : output.by_lead) {
    const auto targets = static_cast<double>(lead.inside.targets());
    if (targets == 0) continue;
    const auto interval = lead.inside.clustered();
    std::snprintf(
        line, sizeof line,
        "  %4.1f .. %-4.1f  %8lld %8lld     %5.2f %%  %5.2f .. %5.2f %%  %14.3f  %11.3f\n",
        lead.from_h, lead.to_h, static_cast<long long>(lead.inside.campaigns()),
        static_cast<long long>(lead.inside.targets()), 100 * lead.inside.rate(), 100 * interval.low,
        100 * interval.high, lead.ratios / targets, std::sqrt(lead.squares / targets));
    out += line;
  }
  return out;
}

}  // namespace

std::vector<CoverageByLead> lead_classes() {
  std::vector<CoverageByLead> out;
  for (const double from_h : {0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0}) {
    out.emplace_back();
    out.back().from_h = from_h;
    out.back().to_h = from_h == 0 ? 0.5 : 2 * from_h;
  }
  return out;
}

double CoverageOfOutput::rms_ratio() const {
  return inside.targets() == 0 ? 0 : std::sqrt(squares / static_cast<double>(inside.targets()));
}

std::vector<CoverageOfOutput> run_coverage(
    const std::function<SimulatedCase(std::uint64_t seed)>& simulate, std::uint64_t first_seed,
    int campaigns, int threads,
    const std::function<void(int done, const std::vector<CoverageOfOutput>& so_far)>& report) {
  std::vector<CoverageOfOutput> sums;
  std::mutex mutex;
  std::exception_ptr trouble;
  int next = 0, done = 0;
  const auto work = [&] {
    for (;;) {
      int mine = 0;
      {
        const std::lock_guard lock(mutex);
        if (trouble || next == campaigns) return;
        mine = next++;
      }
      try {
        const auto served =
            serve_and_judge(simulate(first_seed + static_cast<std::uint64_t>(mine)));
        const std::lock_guard lock(mutex);
        add_campaign(served, sums);  // sums only: their order does not matter to the counts
        report(++done, sums);
      } catch (...) {
        const std::lock_guard lock(mutex);
        trouble = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> workers;
    for (int i = 1; i < threads; ++i) workers.emplace_back(work);
    work();
  }
  if (trouble) std::rethrow_exception(trouble);
  return sums;
}

std::string coverage_table(const std::vector<CoverageOfOutput>& outputs) {
  char line[256];
  std::string out =
      "output  campaigns  targets   within 2u     rate  95 % per target   95 % by campaign  "
      "rms error  rms error/u  outside\n";
  for (const auto& output : outputs) {
    const auto plain = output.inside.per_target(), clustered = output.inside.clustered();
    const auto targets = static_cast<double>(output.inside.targets());
    std::snprintf(
        line, sizeof line,
        "%-7s %9lld %8lld %11lld  %5.2f %%  %5.2f .. %5.2f %%  %5.2f .. %5.2f %%  %6.2f nm  "
        "%11.3f  %7lld\n",
        output.channel.c_str(), static_cast<long long>(output.inside.campaigns()),
        static_cast<long long>(output.inside.targets()),
        static_cast<long long>(output.inside.hits()), 100 * output.inside.rate(), 100 * plain.low,
        100 * plain.high, 100 * clustered.low, 100 * clustered.high,
        std::sqrt(output.error_nm2 / targets), output.rms_ratio(),
        static_cast<long long>(output.outside));
    out += line;
  }
  out += "budget, rms over the targets, nm:\n";
  for (const auto& output : outputs) {
    if (output.channel == "all") continue;
    out += "  " + output.channel + ":";
    for (std::size_t i = 0; i < output.line_nm2.size(); ++i) {
      if (!(output.line_nm2[i] > 0)) continue;
      const auto source = compensation::to_string(static_cast<compensation::UncertaintySource>(i));
      std::snprintf(line, sizeof line, " %.*s %.2f", static_cast<int>(source.size()), source.data(),
                    std::sqrt(output.line_nm2[i] / static_cast<double>(output.inside.targets())));
      out += line;
    }
    out += "\n";
  }
  const auto& all = outputs.back();
  const auto resampled = all.inside.resampled();
  std::snprintf(line, sizeof line, "all, 95 %% by resampling whole campaigns: %5.2f .. %5.2f %%\n",
                100 * resampled.low, 100 * resampled.high);
  return out + line + table_by_lead(all);
}

}  // namespace driftwise::statistics
