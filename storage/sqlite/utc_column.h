#pragma once
// What every schema version writes beside a column of UTC nanoseconds. Never edited once released.

// Reads a column of UTC nanoseconds as text. Generated (virtual) columns made with it take no room
// in the file.
#define DRIFTWISE_UTC_COLUMN(name)                         \
  name "_utc TEXT AS (strftime('%Y-%m-%dT%H:%M:%S', " name \
       "_ns / 1000000000, 'unixepoch') || "                \
       "printf('.%09dZ', " name "_ns % 1000000000)) VIRTUAL"
