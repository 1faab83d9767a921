#include "storage/models/model_store.h"

#include <set>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::storage {
namespace {

ModelRecord model_from(const Query& row) {
  ModelRecord model{{row.integer(0)}, row.text(1), row.text(2), row.text(3), {},
                    {row.integer(5)}, row.text(6), row.text(7)};
  if (const auto parent = row.optional_integer(4)) model.parent = ModelId{*parent};
  return model;
}

void read_corrections_of(Session& session, ModelRecord& model) {
  Query query(
      session.db,
      "SELECT correction_id FROM model_correction WHERE model_id = ? ORDER BY correction_id");
  query.bind(model.id);
  while (query.row()) model.corrections.push_back({query.integer(0)});
}

[[noreturn]] void throw_no_such_model(Session& session, ModelId id) {
  throw_failure(ErrorCode::not_found, reasons::kNoSuchModel,
                "there is no model " + std::to_string(id.value) + " in database " +
                    session.db.path() + ": 'driftwise model list' shows those there are");
}

ModelRecord read_model(Session& session, ModelId id) {
  Query query(session.db,
              "SELECT model_id, name, json, hash, parent_id, created_ns, created_by, note FROM "
              "model WHERE model_id = ?");
  if (!query.bind(id.value).row()) throw_no_such_model(session, id);
  auto model = model_from(query);
  read_corrections_of(session, model);
  return model;
}

Result<std::vector<std::int64_t>> ids_by(Session& session, const char* sql) {
  return session.read([&] {
    std::vector<std::int64_t> found;
    Query query(session.db, sql);
    while (query.row()) found.push_back(query.integer(0));
    return found;
  });
}

// From the table and, where a page of it is damaged, from the index over the hashes, which has
// pages of its own. Errors: neither can be read.
Result<std::set<std::int64_t>> model_ids(Session& session) {
  const auto by_table = ids_by(session, "SELECT model_id FROM model NOT INDEXED");
  const auto by_hash =
      ids_by(session, "SELECT model_id FROM model INDEXED BY sqlite_autoindex_model_1");
  if (!by_table && !by_hash) return tl::unexpected(by_table.error());
  std::set<std::int64_t> ids;
  if (by_table) ids.insert(by_table->begin(), by_table->end());
  if (by_hash) ids.insert(by_hash->begin(), by_hash->end());
  return ids;
}

}  // namespace

ModelId insert_model(Session& session, const ModelRecord& model) {
  ModelId id;
  Query same(session.db, "SELECT model_id FROM model WHERE hash = ?");
  if (same.bind(model.hash).row()) {
    id = {same.integer(0)};
  } else {
    Query(session.db,
          "INSERT INTO model (name, json, hash, parent_id, created_ns, created_by, note) VALUES "
          "(?, ?, ?, ?, ?, ?, ?)")
        .bind(model.name, model.json, model.hash, model.parent, model.created.utc_ns,
              model.created_by, model.note)
        .run();
    id = {session.db.last_row_id()};
  }
  for (const CorrectionId correction : model.corrections)
    Query(session.db,
          "INSERT OR IGNORE INTO model_correction (model_id, correction_id) VALUES (?, ?)")
        .bind(id, correction)
        .run();
  return id;
}

void insert_promotion(Session& session, const PromotionRecord& promotion) {
  Query(session.db, "INSERT INTO promotion (model_id, at_ns, by_whom, action) VALUES (?, ?, ?, ?)")
      .bind(promotion.model, promotion.at.utc_ns, promotion.by, promotion.action)
      .run();
}

void require_model(Session& session, ModelId id) {
  Query query(session.db, "SELECT 1 FROM model WHERE model_id = ?");
  if (!query.bind(id.value).row()) throw_no_such_model(session, id);
}

Result<ModelId> SqliteModelStore::add_model(const ModelRecord& model) {
  return session_.write([&] { return insert_model(session_, model); });
}

Result<ModelRecord> SqliteModelStore::model(ModelId id) {
  return session_.read([&] { return read_model(session_, id); });
}

// Each in a transaction of its own: one damaged row does not hide the others.
Result<std::vector<ModelRecord>> SqliteModelStore::models() {
  DRIFTWISE_TRY(const auto ids, model_ids(session_));
  std::vector<ModelRecord> models;
  for (const std::int64_t id : ids) {
    auto found = session_.read([&] { return read_model(session_, {id}); });
    if (!found) {
      ModelRecord damaged;
      damaged.id = {id};
      damaged.name = "(damaged)";
      damaged.damage = found.error().message;
      found = std::move(damaged);
    }
    models.push_back(std::move(*found));
  }
  return models;
}

Result<void> SqliteModelStore::add_promotion(const PromotionRecord& promotion) {
  return session_.write([&] { insert_promotion(session_, promotion); });
}

Result<std::vector<PromotionRecord>> SqliteModelStore::promotions() {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT model_id, at_ns, by_whom, action FROM promotion ORDER BY promotion_id");
    std::vector<PromotionRecord> promotions;
    while (query.row()) {
      PromotionRecord promotion{{}, {query.integer(1)}, query.text(2), query.text(3)};
      if (const auto model = query.optional_integer(0)) promotion.model = ModelId{*model};
      promotions.push_back(std::move(promotion));
    }
    return promotions;
  });
}

}  // namespace driftwise::storage
