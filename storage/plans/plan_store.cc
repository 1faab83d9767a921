#include "storage/plans/plan_store.h"

#include "server/core/reasons.h"
#include "storage/models/model_store.h"

namespace driftwise::storage {
namespace {

// A statement's text is a literal: its address is what it is kept by.
constexpr const char* kOnePlan =
    "SELECT plan_id, name, version, text, hash, request_id, created_ns, created_by, created_from, "
    "note FROM plan WHERE plan_id = ?";
constexpr const char* kAllPlans =
    "SELECT plan_id, name, version, text, hash, request_id, created_ns, created_by, created_from, "
    "note FROM plan ORDER BY plan_id";

PlanRecord plan_from(const Query& row) {
  PlanRecord plan;
  plan.id = {row.integer(0)};
  plan.name = row.text(1);
  plan.version = static_cast<int>(row.integer(2));
  plan.text = row.text(3);
  plan.hash = row.text(4);
  plan.request_id = row.text(5);
  plan.created = {row.integer(6)};
  plan.created_by = row.text(7);
  plan.created_from = row.text(8);
  plan.note = row.text(9);
  return plan;
}

void read_models_of(Session& session, PlanRecord& plan) {
  Query query(session.db,
              "SELECT model_id, hash FROM plan_model WHERE plan_id = ? ORDER BY model_id");
  query.bind(plan.id);
  while (query.row()) plan.models.emplace_back(ModelId{query.integer(0)}, query.text(1));
}

PlanRecord read_plan(Session& session, PlanId id) {
  Query query(session.db, kOnePlan);
  if (!query.bind(id.value).row())
    throw_failure(ErrorCode::not_found, reasons::kNoSuchPlan,
                  "there is no plan " + std::to_string(id.value) +
                      ": 'driftwise plan list' shows those there are");
  auto plan = plan_from(query);
  read_models_of(session, plan);
  return plan;
}

// What an earlier call stored: by its request, else by the text.
std::optional<PlanId> stored_before(Session& session, const PlanRecord& plan) {
  if (!plan.request_id.empty()) {
    Query query(session.db, "SELECT plan_id, hash FROM plan WHERE request_id = ?");
    if (query.bind(plan.request_id).row()) {
      if (query.text(1) == plan.hash) return PlanId{query.integer(0)};
      throw_failure(ErrorCode::failed_precondition, reasons::kRequestIdReused,
                    "request_id '" + plan.request_id + "' belongs to plan " +
                        std::to_string(query.integer(0)) + ", whose text is another one");
    }
  }
  Query query(session.db, "SELECT plan_id FROM plan WHERE hash = ?");
  if (query.bind(plan.hash).row()) return PlanId{query.integer(0)};
  return std::nullopt;
}

}  // namespace

Result<PlanRecord> SqlitePlanStore::add_plan(const PlanRecord& plan) {
  return session_.write([&] {
    if (const auto before = stored_before(session_, plan)) return read_plan(session_, *before);
    for (const auto& [model, hash] : plan.models) require_model(session_, model);
    Query(session_.db,
          "INSERT INTO plan (name, version, text, hash, request_id, created_ns, created_by, "
          "created_from, note) VALUES (?1, (SELECT COALESCE(MAX(version), 0) + 1 FROM plan WHERE "
          "name = ?1), ?2, ?3, ?4, ?5, ?6, ?7, ?8)")
        .bind(plan.name, plan.text, plan.hash, plan.request_id, plan.created.utc_ns,
              plan.created_by, plan.created_from, plan.note)
        .run();
    const PlanId id{session_.db.last_row_id()};
    for (const auto& [model, hash] : plan.models)
      Query(session_.db, "INSERT INTO plan_model (plan_id, model_id, hash) VALUES (?, ?, ?)")
          .bind(id, model, hash)
          .run();
    return read_plan(session_, id);
  });
}

Result<PlanRecord> SqlitePlanStore::plan(PlanId id) {
  return session_.read([&] { return read_plan(session_, id); });
}

Result<std::vector<PlanRecord>> SqlitePlanStore::plans() {
  return session_.read([&] {
    std::vector<PlanRecord> all;
    Query query(session_.db, kAllPlans);
    while (query.row()) all.push_back(plan_from(query));
    for (auto& plan : all) read_models_of(session_, plan);
    return all;
  });
}

Result<void> SqlitePlanStore::add_plan_promotion(const PlanPromotionRecord& promotion) {
  return session_.write([&] {
    Query(session_.db,
          "INSERT INTO plan_promotion (plan_id, at_ns, by_whom, from_where, action) VALUES (?, ?, "
          "?, ?, ?)")
        .bind(promotion.plan, promotion.at.utc_ns, promotion.by, promotion.from, promotion.action)
        .run();
  });
}

Result<std::vector<PlanPromotionRecord>> SqlitePlanStore::plan_promotions() {
  return session_.read([&] {
    Query query(session_.db,
                "SELECT plan_id, at_ns, by_whom, from_where, action FROM plan_promotion ORDER BY "
                "plan_promotion_id");
    std::vector<PlanPromotionRecord> promotions;
    while (query.row()) {
      PlanPromotionRecord promotion{
          {}, {query.integer(1)}, query.text(2), query.text(3), query.text(4)};
      if (const auto plan = query.optional_integer(0)) promotion.plan = PlanId{*plan};
      promotions.push_back(std::move(promotion));
    }
    return promotions;
  });
}

}  // namespace driftwise::storage
