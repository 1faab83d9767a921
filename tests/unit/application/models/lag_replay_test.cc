// A model with a lag that begins to serve hours after the zero of its datum, on the real store.

#include <gtest/gtest.h>

#include <cmath>

#include "server/application/serving/memory.h"
#include "server/application/serving/past_targets.h"
#include "server/compensation/correction_parts.h"
#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"
#include "tests/unit/compensation/models.h"

namespace driftwise::tests {
namespace {

using compensation::SnapshotBuilder;

class LagReplay : public testing::Test {
 protected:
  LagReplay() { cell.devices[1].channels = {{"t07", "degC"}}; }

  static CellTime hour(double h) {
    return CellTime{1'300'000'000'000'000'000} + nanoseconds_from_s(h * 3600);
  }
  // Swings, and rises by 0.5 K/h from the zero, hour 0, on.
  static double room_degc(double h) {
    return 20.5 + 0.3 * std::sin(h / 4) + 0.5 * std::max(0.0, h);
  }
  static Reading reading(double h) {
    return {"scanner", hour(h), hour(h), std::llround(h * 60), {{"t07_degC", room_degc(h)}}};
  }
  static std::vector<Reading> readings(double from_h, double to_h) {
    std::vector<Reading> out;
    for (double h = from_h; h < to_h; h += 1.0 / 60) out.push_back(reading(h));
    return out;
  }
  // q1 = x + 1 um/K behind a lag.
  static calibration::Model lagging(double tau_s) {
    auto model = compensation::axis_model();
    auto& q1 = model.outputs[0];
    q1.terms = {compensation::term({}),
                compensation::term({compensation::power("x")}),
                {{effects::Call{"lag", {"t07"}, {{tau_s, "s"}}}}}};
    q1.coefficients.resize(3);
    q1.coefficients << 0, 1, 1e-3;
    q1.covariance = Eigen::MatrixXd::Identity(3, 3) * 1e-16;
    return model;
  }
  SnapshotBuilder builder_of(double tau_s) const {
    return *SnapshotBuilder::create(lagging(tau_s), ModelId{1}, cell);
  }
  static DatumRecord datum() {
    DatumRecord zero;
    zero.opened.utc = hour(0);
    zero.values = {{"q1_mm", 0.0}, {"t07_degC", room_degc(0)}};
    return zero;
  }
  // The daemon that was there when the zero was taken.
  SnapshotBuilder never_stopped(double tau_s) const {
    auto builder = builder_of(tau_s);
    for (const auto& one : readings(-200, kNow_h)) {
      if (one.start > hour(0) && !anchored(builder)) {
        EXPECT_TRUE(builder.anchor(datum().values));
      }
      builder.observe(one);
    }
    return builder;
  }
  static bool anchored(const SnapshotBuilder& builder) { return builder.build(hour(0)).anchored; }
  static double target_mm(const SnapshotBuilder& builder) {
    compensation::TargetRequest request;
    request.set(compensation::Variable::x, 1.0);
    return compensation::compute_target(builder.build(hour(kNow_h)), request).q_mm[0];
  }

  static constexpr double kNow_h = 3;
  Folder folder;
  CellDescription cell = compensation::axis_cell();
  std::unique_ptr<Store> store = *kSqlite(folder / "cell.sqlite", false);
};

TEST_F(LagReplay, ServesAsTheDaemonThatWasThereAtTheZero) {
  ASSERT_TRUE(store->readings().append(readings(-200, kNow_h), {}));
  for (const double tau_s : {3600.0, 43200.0}) {  // ten of the second are 120 h
    const auto live = never_stopped(tau_s);
    auto later = builder_of(tau_s);
    const auto stored = application::readings_for_memory(
        *store, cell, {later.observed_channels(), later.memory(), hour(0)}, hour(kNow_h));
    ASSERT_TRUE(stored) << stored.error().message;
    application::replay(*stored, hour(0), later,
                        [&] { EXPECT_TRUE(later.anchor(datum().values)); });
    EXPECT_NEAR(target_mm(later), target_mm(live), 1e-7) << tau_s;  // 0.1 nm
  }
}

TEST_F(LagReplay, PastTargetsOfACarriedDatumCountFromItsZero) {
  ASSERT_TRUE(store->readings().append(readings(-200, kNow_h), {}));
  for (const double tau_s : {3600.0, 43200.0}) {
    application::PastTargetsQuery query;
    query.pose.set(compensation::Variable::x, 1.0);
    query.count = 30;  // two readings in each
    const auto past = application::past_targets(
        *store, cell, {lagging(tau_s), ModelId{1}, datum(), false}, query, hour(kNow_h));
    ASSERT_TRUE(past) << past.error().message;
    const auto live = never_stopped(tau_s).build(hour(kNow_h));
    const auto now = compensation::correction_parts(live, query.pose, 0);
    ASSERT_TRUE(now);
    // The last mean is some minutes old: 9 nm a minute.
    EXPECT_NEAR(past->tracks[0].correction_nm.back(), now->sum_nm(), 30) << tau_s;
  }
}

TEST_F(LagReplay, WithoutReadingsBeforeTheZeroTheDatumIsNotAnchored) {
  ASSERT_TRUE(store->readings().append(readings(0.5, kNow_h), {}));
  auto later = builder_of(3600);
  const auto stored = application::readings_for_memory(
      *store, cell, {later.observed_channels(), later.memory(), hour(0)}, hour(kNow_h));
  ASSERT_TRUE(stored) << stored.error().message;
  std::string reason;
  application::replay(*stored, hour(0), later, [&] {
    const auto anchor = later.anchor(datum().values);
    reason = anchor ? "anchored" : anchor.error().reason;
  });
  EXPECT_EQ(reason, "INCOMPLETE_DATUM");
  EXPECT_FALSE(anchored(later));
}

}  // namespace
}  // namespace driftwise::tests
