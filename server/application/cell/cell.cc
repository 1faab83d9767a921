#include "server/application/cell/cell.h"

#include <fmt/format.h>

#include "server/application/cell/composition.h"
#include "server/application/improvement/unproved_extension.h"
#include "server/core/try.h"

namespace driftwise::application {

namespace {

// Of every controller, as a stop that a daemon was asked for: with the pause of the run and the
// hold of the queue.
Result<void> store_kept_stop(Store& store, const CellDescription& description,
                             const formats::KeptStop& kept, Stamp now) {
  std::vector<StopRecord> stops;
  for (const auto& device : description.devices)
    if (device.role() == DeviceRole::motion)
      stops.push_back({{},
                       device.id,
                       kept.who,
                       formats::kKeptStopFile,
                       fmt::format("stopped by {}", kept.who),
                       now,
                       1,
                       {},
                       kept.who,
                       now.utc});
  DRIFTWISE_TRY(const auto stored, store.stops().keep(stops));
  static_cast<void>(stored);
  return {};
}

}  // namespace

Result<std::unique_ptr<Cell>> Cell::open(asio::any_io_executor executor, Parts parts) {
  DRIFTWISE_TRY(auto writing, parts.open_store(parts.description.database, false));
  DRIFTWISE_TRY(auto reading, parts.open_store(parts.description.database, true));
  DRIFTWISE_TRY(auto checking, parts.open_store(parts.description.database, true));
  DRIFTWISE_TRY(auto clocks, writing->clocks().clocks());
  DRIFTWISE_TRY(const auto newest, writing->clocks().newest_instant());
  auto clock_start = begin_cell_time(*parts.clock, std::move(clocks), newest);
  DRIFTWISE_RETURN_IF_ERROR(writing->clocks().add_clock(clock_start.records.back()));
  // Before anybody can begin a new one.
  DRIFTWISE_TRY(auto interrupted, end_interrupted_improvement(*writing, parts.clock->now()));
  DRIFTWISE_TRY(const auto unfinished,
                writing->diagnoses().fail_unfinished("the daemon ended while it ran",
                                                     parts.clock->now().utc));
  if (parts.kept_stop)
    DRIFTWISE_RETURN_IF_ERROR(
        store_kept_stop(*writing, parts.description, *parts.kept_stop, parts.clock->now()));
  DRIFTWISE_TRY(auto stops, writing->stops().pending());
  DRIFTWISE_TRY(auto queue, writing->queue().queue(QueueDesk::kHistory));
  DRIFTWISE_TRY(auto configuration, ConfigurationBook::open(*writing, parts.description,
                                                            parts.version, parts.clock->now()));
  OpenedRecord opened{
      std::move(writing),     std::move(reading), std::move(checking), std::move(configuration),
      std::move(clock_start), std::move(stops),   std::move(queue),    unfinished,
      std::move(interrupted)};
  return std::unique_ptr<Cell>(
      new Cell(std::make_unique<Composition>(executor, std::move(parts), std::move(opened))));
}

Cell::Cell(std::unique_ptr<Composition> parts)
    : parts_(std::move(parts)), services_(parts_->services()) {}

Cell::~Cell() = default;

void Cell::start() { parts_->start(); }

access::AccessWitness& Cell::access_witness() { return parts_->access; }
void Cell::ask_for_ends(std::function<std::vector<access::EndingProof>()> ends) {
  parts_->access.ask_for_ends(std::move(ends));
}

Awaitable<void> Cell::devices_looked_at() { return parts_->keeper.looked(); }

Awaitable<void> Cell::served_again() { return parts_->served_again(); }

Awaitable<void> Cell::come_to_rest() { return parts_->come_to_rest(); }

bool Cell::all_ended() const { return parts_->tasks.count() == 0; }

Awaitable<void> Cell::shut_down() { return parts_->shut_down(); }

std::optional<formats::KeptStop> Cell::halt_not_on_record() const {
  if (const auto stop = parts_->stops.unstored())
    return formats::KeptStop{stop->who, to_iso8601(parts_->clock->utc(stop->asked.utc))};
  const auto& progress = parts_->engine.progress();
  if (!progress || !progress->unstored) return std::nullopt;
  // A run that is over and is not on record as such would be continued by the next start.
  if (progress->run.state != RunState::paused && !is_over(progress->run.state)) return std::nullopt;
  const auto& hold = progress->run.hold;
  return formats::KeptStop{hold.who.empty() ? "the daemon" : hold.who,
                           to_iso8601(parts_->clock->utc(hold.at))};
}

}  // namespace driftwise::application
