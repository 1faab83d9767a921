#include "storage/sqlite/names.h"

#include "server/core/channel.h"
#include "server/core/reasons.h"
#include "storage/sqlite/failure.h"
#include "storage/sqlite/wide_views.h"

namespace driftwise::storage {
namespace {

// A cell has tens of channels; imports could bring any number, and no name ever goes again.
constexpr std::size_t kMostNamesForImports = 1000;

void require_room_for_import(std::size_t names, const std::string& name, const std::string& path) {
  if (names < kMostNamesForImports) return;
  throw_failure(ErrorCode::resource_exhausted, reasons::kTooManyChannels,
                "database " + path + " holds " + std::to_string(names) +
                    " names of channels; imports may add names up to " +
                    std::to_string(kMostNamesForImports) + " in all, and '" + name +
                    "' is new. Nothing was imported: give the columns names that the record has "
                    "(data import --mapping), leave out those that no fit needs, or import into "
                    "another database");
}

}  // namespace

std::int64_t Names::channel(const std::string& name, Use use) {
  auto found = channels_.find(name);
  if (found == channels_.end()) {
    load();
    found = channels_.find(name);
  }
  if (found == channels_.end()) {
    const auto parsed = parse_robot_channel(name);
    if (!parsed) throw StorageFailure{parsed.error()};
    if (use == Use::imported) require_room_for_import(channels_.size(), name, db_.path());
    Query(db_, "INSERT INTO channel (name) VALUES (?)").bind(name).run();
    const std::int64_t id = db_.last_row_id();
    channel_names_[id] = name;
    found = channels_.emplace(name, Known{id, false, false}).first;
  }
  Known& known = found->second;
  if ((use == Use::point || use == Use::imported) && !known.in_point) {
    Query(db_, "UPDATE channel SET in_point = 1 WHERE channel_id = ?").bind(known.id).run();
    known.in_point = point_view_stale_ = true;
  }
  if (use == Use::reading && !known.in_reading) {
    Query(db_, "UPDATE channel SET in_reading = 1 WHERE channel_id = ?").bind(known.id).run();
    known.in_reading = reading_view_stale_ = true;
  }
  return known.id;
}

std::int64_t Names::device(const std::string& name) {
  if (const auto found = device_ids_.find(name); found != device_ids_.end()) return found->second;
  load();
  if (const auto found = device_ids_.find(name); found != device_ids_.end()) return found->second;
  Query(db_, "INSERT INTO device (name) VALUES (?)").bind(name).run();
  const std::int64_t id = db_.last_row_id();
  devices_[id] = name;
  device_ids_[name] = id;
  return id;
}

const std::string& Names::channel_name(std::int64_t id) {
  if (!channel_names_.contains(id)) load();
  const auto found = channel_names_.find(id);
  if (found == channel_names_.end())
    throw_failure(ErrorCode::data_loss, reasons::kDatabaseDamaged,
                  "database " + db_.path() + ": a value names channel_id " + std::to_string(id) +
                      ", which table channel does not have: restore a backup");
  return found->second;
}

const std::string& Names::device_name(std::int64_t id) {
  if (!devices_.contains(id)) load();
  const auto found = devices_.find(id);
  if (found == devices_.end())
    throw_failure(ErrorCode::data_loss, reasons::kDatabaseDamaged,
                  "database " + db_.path() + ": a reading names device_id " + std::to_string(id) +
                      ", which table device does not have: restore a backup");
  return found->second;
}

const std::map<std::int64_t, std::string>& Names::devices() {
  load();
  return devices_;
}

void Names::load() {
  Query channels(db_, "SELECT channel_id, name, in_point, in_reading FROM channel");
  while (channels.row()) {
    const std::int64_t id = channels.integer(0);
    const std::string name = channels.text(1);
    channel_names_[id] = name;
    channels_.insert_or_assign(name, Known{id, channels.integer(2) != 0, channels.integer(3) != 0});
  }
  Query named(db_, "SELECT device_id, name FROM device");
  while (named.row()) {
    const std::int64_t id = named.integer(0);
    device_ids_[named.text(1)] = id;
    devices_[id] = named.text(1);
  }
}

void Names::refresh_views() {
  if (point_view_stale_) rebuild_point_wide(db_);
  if (reading_view_stale_) rebuild_reading_wide(db_);
  point_view_stale_ = reading_view_stale_ = false;
}

void Names::forget() {
  channels_.clear();
  device_ids_.clear();
  channel_names_.clear();
  devices_.clear();
  point_view_stale_ = reading_view_stale_ = false;
}

}  // namespace driftwise::storage
