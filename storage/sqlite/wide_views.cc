#include "storage/sqlite/wide_views.h"

#include <string>

namespace driftwise::storage {
namespace {

// SQLite takes 2000 columns in a view, which has up to ten of its own: the first 1900 channels have
// one. All have their rows in the narrow tables. Channel names are letters, digits and '_'
// (parse_channel), so they need quotes but no escaping.
std::string value_columns(Query& channels, const std::string& table, const std::string& key) {
  std::string columns;
  while (channels.row())
    columns += ",\n  (SELECT value FROM " + table + " v WHERE v." + key + " = r." + key +
               " AND v.channel_id = " + std::to_string(channels.integer(0)) + ") AS \"" +
               channels.text(1) + "\"";
  return columns;
}

}  // namespace

void rebuild_point_wide(Database& db) {
  Query channels(
      db, "SELECT channel_id, name FROM channel WHERE in_point = 1 ORDER BY channel_id LIMIT 1900");
  const std::string columns = value_columns(channels, "point_value", "point_id");
  db.execute("DROP VIEW IF EXISTS point_wide");
  db.execute(
      "CREATE VIEW point_wide AS SELECT r.point_id, r.run_id, r.datum_id, r.trajectory_row, "
      "r.point_set, r.line,\n"
      "  r.is_zero, EXISTS (SELECT 1 FROM passage x WHERE x.point_id = r.point_id) AS is_passage, "
      "r.dwell_s, r.measured_utc, r.measured_ns" +
      columns +
      "\nFROM point r WHERE NOT EXISTS (SELECT 1 FROM repeated_point x WHERE x.point_id = "
      "r.point_id)");
}

void rebuild_reading_wide(Database& db) {
  Query channels(
      db,
      "SELECT channel_id, name FROM channel WHERE in_reading = 1 ORDER BY channel_id LIMIT 1900");
  const std::string columns = value_columns(channels, "reading_value", "reading_id");
  db.execute("DROP VIEW IF EXISTS reading_wide");
  db.execute(
      "CREATE VIEW reading_wide AS SELECT r.reading_id, d.name AS device, r.start_utc, r.start_ns, "
      "r.end_ns,\n"
      "  r.sequence, r.attempt_id" +
      columns + "\nFROM reading r JOIN device d ON d.device_id = r.device_id");
}

}  // namespace driftwise::storage
