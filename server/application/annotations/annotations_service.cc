#include "server/application/annotations/annotations_service.h"

#include <fmt/format.h>

#include <set>

#include "server/core/try.h"
#include "server/formats/text/row_ranges.h"

namespace driftwise::application {
namespace {

// Points of an empty run have no dataset.
std::string hash_of(Store& store, RunId run, bool any_out) {
  if (!any_out) return {};
  const auto dataset = store.runs().dataset(std::vector{run});
  return dataset ? formats::exclusions_hash(*dataset) : std::string();
}

Result<ExclusionState> state_of(Store& store, RunId run) {
  DRIFTWISE_TRY(auto history, store.remarks().exclusions(run));
  std::set<std::int64_t> out, suspect;
  for (const auto& step : history)
    for (const std::int64_t row : step.rows)
      if (step.excluded) {
        out.insert(row);
        if (step.suspect) suspect.insert(row);
      } else {
        out.erase(row);
        suspect.erase(row);
      }
  return ExclusionState{run,
                        {out.begin(), out.end()},
                        {suspect.begin(), suspect.end()},
                        hash_of(store, run, !out.empty()),
                        std::move(history)};
}

std::string subject_text(const NoteSubject& on) {
  if (on.model) return fmt::format("model {}", on.model->value);
  if (on.row) return fmt::format("run {}, row {}", on.run->value, *on.row + 1);
  return fmt::format("run {}", on.run->value);
}

}  // namespace

Awaitable<Result<ExclusionState>> AnnotationsService::exclude_rows(Caller caller,
                                                                   ExclusionRecord wanted) {
  wanted.at = clock_.now();
  wanted.who = caller.name;
  wanted.from = caller.peer;
  DRIFTWISE_CO_TRY(auto stored, co_await writer_.remarks().exclude(wanted));
  if (!stored.rows.empty()) {
    std::vector<std::int64_t> from_one = stored.rows;  // the record counts from 0
    for (auto& row : from_one) ++row;
    const auto rows = formats::row_ranges_told(from_one);
    auto detail =
        fmt::format("{} {} of run {} {} fits: {}", caller.name,
                    stored.excluded ? "keeps rows " + rows : "puts rows " + rows, stored.run.value,
                    stored.excluded ? "out of" : "back into", stored.reason);
    events_.record(
        caller, stored.excluded ? "data.excluded" : "data.restored", std::move(detail), stored.run,
        {fmt::format("run {} rows {}", stored.run.value, rows),
         stored.excluded ? "in fits" : "out of fits", stored.excluded ? "out of fits" : "in fits"});
  }
  co_return co_await exclusions(wanted.run);
}

Awaitable<Result<ExclusionState>> AnnotationsService::exclusions(RunId run) {
  co_return co_await reader_.call([=](Store& store) { return state_of(store, run); });
}

Awaitable<Result<NoteRecord>> AnnotationsService::add_note(Caller caller, NoteSubject on,
                                                           std::string text) {
  NoteRecord note{0, on, std::move(text), clock_.now(), caller.name, caller.peer};
  auto stored = co_await writer_.remarks().add_note(note);
  if (stored)
    events_.record(caller, "note.added",
                   fmt::format("{} on {}: {}", caller.name, subject_text(on), stored->text),
                   on.run);
  co_return stored;
}

}  // namespace driftwise::application
