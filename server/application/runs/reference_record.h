#pragma once
// Reference of a run's axes over restarts of the daemon: a loss of power is told by it. Each change
// is a reading of its own device.

#include <optional>

#include "server/application/plumbing/store_writer.h"

namespace driftwise::application {

// One value, referenced_1: 1 while every axis of the cell is referenced, else 0.
inline constexpr const char* kReferenceDevice = "reference";

// At this instant. Goes to disk at once, or with what gathers for a disk that takes nothing.
// sequence: tells readings of one instant apart.
Awaitable<void> keep_reference(StoreWriter& writer, CellTime at, std::int64_t sequence,
                               bool referenced);

// Newest one from the first instant up to and including the last; empty: none.
Awaitable<std::optional<bool>> kept_reference(StoreWriter& writer, CellTime first, CellTime last);

}  // namespace driftwise::application
