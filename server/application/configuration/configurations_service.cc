#include "server/application/configuration/configurations_service.h"

#include <fmt/format.h>

#include "server/application/plumbing/crash_point.h"
#include "server/application/provenance/stored_description.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::application {

Awaitable<Result<ConfigurationView>> ConfigurationsService::get(std::string hash,
                                                                std::string compare_hash) {
  if (hash.empty()) hash = description_.hash;
  if (compare_hash.empty()) compare_hash = description_.hash;
  co_return co_await reader_.call(
      [present = &description_](Store& store, const std::string& shown,
                                const std::string& other) -> Result<ConfigurationView> {
        DRIFTWISE_TRY(auto text, store.configurations().text(shown));
        ConfigurationView view{shown, std::move(text), other, {}};
        if (shown == other) return view;
        DRIFTWISE_RETURN_IF_ERROR(store.configurations().text(other));
        const auto compared = stored_description(store, other, *present);
        if (!compared)
          return fail(
              ErrorCode::failed_precondition, reasons::kOldConfiguration,
              fmt::format("configuration {} cannot be read by this program: it can be shown, not "
                          "compared with",
                          other));
        view.changes = formats::cell_file_difference(view.text, *compared);
        return view;
      },
      hash, compare_hash);
}

Awaitable<Result<ConfigurationStart>> ConfigurationsService::accept(Caller caller, std::string hash,
                                                                    std::string note) {
  if (!configuration_.asks())
    co_return fail(ErrorCode::failed_precondition, reasons::kNoQuestion,
                   fmt::format("configuration {} puts no question: there is nothing to accept",
                               description_.hash));
  if (hash != description_.hash)
    co_return fail(ErrorCode::failed_precondition, reasons::kOtherConfiguration,
                   fmt::format("configuration '{}' was seen, {} is in force: look at the present "
                               "difference ('driftwise configuration show')",
                               hash, description_.hash));
  const auto* run = engine_.record();
  const bool continues = run && !configuration_.question_for(*run).empty();
  std::optional<RunId> continued;
  if (continues) continued = run->id;
  const auto at = clock_.now().utc;
  auto accepted = co_await writer_.configurations().accept(configuration_.start().id, at,
                                                           caller.name, note, continued);
  if (!accepted) co_return accepted;
  configuration_.answered(*accepted);
  events_.record(caller, "configuration.accepted",
                 fmt::format("{} accepted configuration {} after {}{}{}", caller.name, hash,
                             accepted->before_hash, note.empty() ? "" : ": ", note),
                 continued, {"configuration", accepted->before_hash, hash});
  serving_.look_again();
  // A pause or a stop of a person's stays; whoever resumes the run ends it.
  if (auto* control = engine_.control();
      control && control->hold().kind == RunHold::Kind::configuration && continued)
    control->resume();
  co_return accepted;
}

}  // namespace driftwise::application
