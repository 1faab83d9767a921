#include "storage/schema/schema.h"

#include <array>
#include <string>

#include "server/core/reasons.h"
#include "storage/schema/schema_v1.h"
#include "storage/schema/schema_v10.h"
#include "storage/schema/schema_v11.h"
#include "storage/schema/schema_v12.h"
#include "storage/schema/schema_v13.h"
#include "storage/schema/schema_v14.h"
#include "storage/schema/schema_v15.h"
#include "storage/schema/schema_v2.h"
#include "storage/schema/schema_v3.h"
#include "storage/schema/schema_v4.h"
#include "storage/schema/schema_v5.h"
#include "storage/schema/schema_v6.h"
#include "storage/schema/schema_v7.h"
#include "storage/schema/schema_v8.h"
#include "storage/schema/schema_v9.h"
#include "storage/sqlite/failure.h"

namespace driftwise::storage {

void refuse_foreign_or_newer(Database& db, int newest) {
  const std::int64_t version = db.pragma("user_version");
  const std::int64_t application = db.pragma("application_id");
  const bool empty = db.pragma("schema_version") == 0;
  if (application != kApplicationId && !(empty && version == 0 && application == 0))
    throw_failure(ErrorCode::failed_precondition, reasons::kNotDriftwise,
                  "database " + db.path() + " was not made by Driftwise (its application_id is " +
                      std::to_string(application) + "): name another file in [cell] database");
  if (version > newest)
    throw_failure(ErrorCode::failed_precondition, reasons::kSchemaNewer,
                  "database " + db.path() + " has schema version " + std::to_string(version) +
                      ", this program knows versions up to " + std::to_string(newest) +
                      ": use the newer Driftwise that wrote it");
}

std::span<const std::string_view> migrations() {
  static constexpr std::array kSteps = std::to_array<std::string_view>({
      kSchemaV1,
      kSchemaV2,
      kSchemaV3,
      kSchemaV4,
      kSchemaV5,
      kSchemaV6,
      kSchemaV7,
      kSchemaV8,
      kSchemaV9,
      kSchemaV10,
      kSchemaV11,
      kSchemaV12,
      kSchemaV13,
      kSchemaV14,
      kSchemaV15,
#ifdef DRIFTWISE_TEST_SCHEMA_STEP
      // Of the tests' second build alone: an upgrade that no release has.
      "CREATE TABLE upgraded (at_ns INTEGER NOT NULL) STRICT",
#endif
  });
  return kSteps;
}

void migrate(Database& db, std::span<const std::string_view> steps) {
  const int newest = static_cast<int>(steps.size());
  refuse_foreign_or_newer(db, newest);
  for (std::int64_t version = db.pragma("user_version"); version < newest; ++version) {
    Transaction transaction(db);
    db.execute(std::string(steps[static_cast<std::size_t>(version)]));
    db.execute("PRAGMA user_version = " + std::to_string(version + 1));
    db.execute("PRAGMA application_id = " + std::to_string(kApplicationId));
    transaction.commit();
  }
}

void require_present_schema(Database& db) {
  refuse_foreign_or_newer(db, schema_version());
  const std::int64_t version = db.pragma("user_version");
  if (version < schema_version())
    throw_failure(ErrorCode::failed_precondition, reasons::kSchemaOlder,
                  "database " + db.path() + " has schema version " + std::to_string(version) +
                      ", this program needs " + std::to_string(schema_version()) +
                      ": start driftwised on it once, which brings it up to date");
}

}  // namespace driftwise::storage
