#pragma once
// The numbers that stand for channel and device names in the narrow tables, and the views that show
// one column per channel. A channel's first use in a point or a reading gives it a column, in the
// same transaction.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>

#include "storage/sqlite/database.h"

namespace driftwise::storage {

class Names {
 public:
  enum class Use { datum, point, reading, imported };  // imported: in a point of a file

  explicit Names(Database& db) : db_(db) {}

  // Inside a write transaction: finds or adds. Throws invalid_argument BAD_CHANNEL
  // (server/core/channel.h), resource_exhausted TOO_MANY_CHANNELS: an import would add to 1000
  // names. A channel of the cell is never refused.
  std::int64_t channel(const std::string& name, Use use);
  std::int64_t device(const std::string& name);

  const std::string& channel_name(std::int64_t id);
  const std::string& device_name(std::int64_t id);
  // Every device that has ever been stored, by id.
  const std::map<std::int64_t, std::string>& devices();

  // Inside a write transaction, at its end: brings point_wide and reading_wide up to date.
  void refresh_views();
  // After a rollback: what was added is not there.
  void forget();

 private:
  struct Known {
    std::int64_t id;
    bool in_point, in_reading;
  };
  void load();

  Database& db_;
  std::unordered_map<std::string, Known> channels_;
  std::unordered_map<std::string, std::int64_t> device_ids_;
  std::map<std::int64_t, std::string> channel_names_, devices_;
  bool point_view_stale_ = false, reading_view_stale_ = false;
};

}  // namespace driftwise::storage
