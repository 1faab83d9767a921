#include "server/application/datasets/instruments.h"

#include <algorithm>
#include <optional>

#include "server/application/ports/run_plan.h"
#include "server/core/data/measured_by.h"
#include "server/core/try.h"
#include "server/formats/cell_file/setup_instruments.h"

namespace driftwise::application {
namespace {

void add_once(std::vector<std::string>& to, const std::vector<std::string>& devices) {
  for (const auto& device : devices)
    if (std::ranges::find(to, device) == to.end()) to.push_back(device);
}

bool is_confined(const correction::LengthShift& shift) {
  return shift.device.empty() || !shift.runs.empty();
}

}  // namespace

Result<Instruments> instruments_of(Store& store, const RunRecord& run) {
  Instruments found;
  if (is_of_file(run)) return found;
  if (run.reason == "imported") {  // joined
    DRIFTWISE_TRY(const auto data, store.runs().dataset({&run.id, 1}));
    for (const auto& coordinate : measured_by_from(data.metadata))
      for (const auto& part : coordinate.parts) add_once(found[coordinate.symbol], part.devices);
    return found;
  }
  const auto used = store.configurations().of_run(run.id);
  if (!used || used->empty()) return found;
  const auto text = store.configurations().text(used->back().hash);
  if (!text) return found;
  const auto setup = setup_of(run);
  for (const auto& [symbol, device] : setup.empty() ? formats::length_instruments(*text)
                                                    : formats::setup_instruments(*text, setup))
    found[symbol] = {device};
  return found;
}

Result<Instruments> instruments_of(Store& store, std::span<const RunId> runs) {
  Instruments all;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    DRIFTWISE_TRY(const auto run, store.runs().run(runs[i]));
    DRIFTWISE_TRY(auto of_run, instruments_of(store, run));
    if (i == 0) {
      all = std::move(of_run);
      continue;
    }
    std::erase_if(all, [&](const auto& one) { return !of_run.contains(one.first); });
    for (auto& [symbol, devices] : all) add_once(devices, of_run.at(symbol));
  }
  return all;
}

Result<correction::DataAmendment> held_for(Store& store, correction::DataAmendment amendment,
                                           std::span<const RunId> runs) {
  if (std::ranges::all_of(amendment.shifts, is_confined)) return amendment;
  std::vector<std::pair<RunId, Instruments>> measured;  // by this cell
  for (const RunId id : runs) {
    DRIFTWISE_TRY(const auto run, store.runs().run(id));
    if (is_of_file(run)) continue;
    DRIFTWISE_TRY(auto instruments, instruments_of(store, run));
    measured.emplace_back(id, std::move(instruments));
  }
  std::erase_if(amendment.shifts, [&](correction::LengthShift& shift) {
    if (is_confined(shift)) return false;
    for (const auto& [run, instruments] : measured) {
      const auto by = instruments.find(shift.axis);
      if (by == instruments.end() || by->second == std::vector{shift.device})
        shift.runs.push_back(run);
    }
    return shift.runs.empty();
  });
  return amendment;
}

}  // namespace driftwise::application
