#pragma once
// Extensions that an improvement accepted and had not proved when the daemon was killed. Before
// anybody else uses the store.

#include <string>

#include "server/core/ports/store.h"

namespace driftwise::application {

// An improvement that is still running on record has failed: its reason says what became of the
// extension of its last turn. That is undone, unless fresh points have judged it, or a person has
// promoted its model. Result: a sentence for its event; empty: there is none. Errors: those of the
// store.
Result<std::string> end_interrupted_improvement(Store& store, const Stamp& now);

}  // namespace driftwise::application
