// The procedure on an ideal pair of robots: a tilted plane, an axis that is pushed by the contact.
#include "server/indentation/procedure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/core/reasons.h"

namespace driftwise::indentation {
namespace {

double tangent(double arcsec) { return std::tan(arcsec / 3600 * std::numbers::pi / 180); }

class IdealCell final : public TouchingCell {
 public:
  double tilt_rx_arcsec = 540, tilt_ry_arcsec = 1296;
  double breaks_at_overlap_mm = 1e9;  // then the work-piece gives way, and nothing pushes back
  int calls_left = 1'000'000;         // then the client is lost
  int steps_left = 1'000'000;         // of the robot below: then a person stops the axes, once
  int steps_after_stop = 0;
  int interrupted_at = -1;  // look(): the person's Ctrl-C, once
  std::vector<std::pair<double, double>> touched{};
  bool above_is_there = true;
  double highest_mm = 0;     // of the robot below
  double deepest_mm = -1e9;  // of the robot below while the other one travelled

  Result<Answer> move_above(double x_mm, double y_mm, double) override {
    if (auto ok = alive(); !ok) return tl::unexpected(std::move(ok).error());
    if (!above_is_there) return fail(ErrorCode::invalid_argument, reasons::kNoChannel, "no mm.q1");
    deepest_mm = std::max(deepest_mm, overlap_mm());
    x_ = x_mm;
    y_ = y_mm;
    return Answer{"ideal"};
  }
  Result<Answer> move_below(double rx_arcsec, double ry_arcsec, double z_mm) override {
    if (auto ok = alive(); !ok) return tl::unexpected(std::move(ok).error());
    if (steps_left < 0) ++steps_after_stop;
    if (steps_left-- == 0) return fail(ErrorCode::aborted, reasons::kRunAborted, "stopped by bob");
    rx_ = rx_arcsec;
    ry_ = ry_arcsec;
    z_ = z_mm;
    highest_mm = std::max(highest_mm, z_);
    if (overlap_mm() > 0 && (touched.empty() || touched.back() != std::pair{x_, y_}))
      touched.emplace_back(x_, y_);
    return Answer{"ideal"};
  }
  Result<Answer> retract_below(double rx_arcsec, double ry_arcsec, double z_mm) override {
    if (z_mm < z_) return move_below(rx_arcsec, ry_arcsec, z_mm);
    if (auto ok = alive(); !ok) return tl::unexpected(std::move(ok).error());
    return Answer{"ideal"};
  }
  Result<void> nudge_above(double dx_mm, double dy_mm) override {
    x_ += dx_mm;
    y_ += dy_mm;
    return {};
  }
  Result<Eigen::MatrixXd> look() override {
    if (auto ok = alive(); !ok) return tl::unexpected(std::move(ok).error());
    if (interrupted_at-- == 0) return fail(ErrorCode::cancelled, reasons::kCancelled, "Ctrl-C");
    gave_way_ = gave_way_ || overlap_mm() > breaks_at_overlap_mm;
    const double push_nm = gave_way_ ? 0 : std::clamp(overlap_mm() * 1e6, 0.0, 220.0);
    return Eigen::MatrixXd::Constant(3, 3, 30 - push_nm);
  }
  Result<void> wait(double) override { return {}; }
  // The instruments stand 3 um beside the robot's own frame at 0.1 mm.
  Result<Here> here() override { return Here{.x_mm = x_ * 1.03, .y_mm = y_}; }

  double overlap_mm() const {
    return z_ - 1.6 + y_ * tangent(rx_ + tilt_rx_arcsec) - x_ * tangent(ry_ + tilt_ry_arcsec);
  }

 private:
  Result<void> alive() {
    if (calls_left-- > 0) return {};
    return fail(ErrorCode::unavailable, reasons::kLinkLost, "the daemon is away");
  }
  double x_ = 0, y_ = 0, z_ = 0, rx_ = 0, ry_ = 0;
  bool gave_way_ = false;
};

ProcedureRules rules() {
  ProcedureRules rules;
  rules.tool = "diamond 3";
  rules.approach = {.depart_mm = 1.58, .highest_mm = 1.63};
  rules.indents = {
      {"A", Line::x, 100, true}, {"C", Line::x, 250, false}, {"B", Line::y, 100, true}};
  return rules;
}

const auto kNobody = [](const ProcedureRecord&) -> Result<void> { return {}; };

TEST(Procedure, AlignsFindsTheZeroAndMakesEveryIndent) {
  IdealCell cell;
  ProcedureRecord record;
  const auto done = carry_out(cell, rules(), record, kNobody);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(record.stage, Stage::microscope);
  EXPECT_EQ(record.corrections, 1);
  EXPECT_NEAR(record.rx_arcsec, -540, 30);  // a step of 250 nm over 2 mm is 26 arcsec
  EXPECT_NEAR(record.ry_arcsec, -1296, 30);
  ASSERT_EQ(record.indents.size(), 3U);
  EXPECT_EQ(record.contacts, 3 + 3 + 1 + 3);
  EXPECT_EQ(record.zero.contact, 7);
  EXPECT_EQ(record.indents[2].touch.contact, 10);
  EXPECT_EQ(record.by, "ideal");
}

TEST(Procedure, PlacesTheClosedLoopIndentsByTheInstruments) {
  IdealCell cell;
  ProcedureRecord record;
  ASSERT_TRUE(carry_out(cell, rules(), record, kNobody));
  EXPECT_NEAR(record.indents[0].placed_x_um, 100, 0.02);
  EXPECT_NEAR(record.indents[1].placed_x_um, 257.5, 0.02);  // open loop: the frame's 3 %
}

TEST(Procedure, RetractsBeforeTheRobotAboveTravels) {
  IdealCell cell;
  ProcedureRecord record;
  ASSERT_TRUE(carry_out(cell, rules(), record, kNobody));
  EXPECT_LT(cell.deepest_mm, -0.5);
}

// A client that is lost at any call: another one goes on and ends with every indent once.
TEST(Procedure, GoesOnAfterItWasLostAnywhere) {
  for (int lost_at = 1; lost_at < 900; lost_at += 7) {
    IdealCell cell;
    cell.calls_left = lost_at;
    ProcedureRecord kept;
    ProcedureRecord first;
    const auto keep = [&kept](const ProcedureRecord& now) -> Result<void> {
      kept = now;
      return {};
    };
    if (carry_out(cell, rules(), first, keep)) break;
    cell.calls_left = 1'000'000;
    ProcedureRecord second = kept;
    const auto done = carry_out(cell, rules(), second, keep);
    ASSERT_TRUE(done) << lost_at << ": " << done.error().message;
    ASSERT_EQ(second.indents.size(), 3U) << lost_at;
    // No surface is used twice.
    auto places = cell.touched;
    std::ranges::sort(places);
    for (std::size_t i = 1; i < places.size(); ++i)
      EXPECT_GT(std::hypot(places[i].first - places[i - 1].first,
                           places[i].second - places[i - 1].second),
                1e-3)
          << "lost at " << lost_at;
  }
}

// A disk that is full at any change of the record, for good or for once: whoever goes on starts
// from the record that was kept last.
TEST(Procedure, RetractsWhereTheRecordCannotBeWritten) {
  int refused = 0;
  for (int full_at = 1;; ++full_at, ++refused) {
    IdealCell cell;
    ProcedureRecord record, kept;
    int changes = 0;
    const auto keep = [&](const ProcedureRecord& now) -> Result<void> {
      if (++changes >= full_at)
        return fail(ErrorCode::failed_precondition, "CANNOT_WRITE", "no space left on device");
      kept = now;
      return {};
    };
    const auto done = carry_out(cell, rules(), record, keep);
    if (done) break;
    EXPECT_EQ(done.error().message, "no space left on device") << full_at;
    EXPECT_LT(cell.overlap_mm(), 0) << full_at << ": the robot below is left in contact";
    EXPECT_FALSE(record.in_contact) << full_at;
    ASSERT_TRUE(carry_out(cell, rules(), kept, kNobody)) << full_at;
    EXPECT_EQ(kept.indents.size(), 3U) << full_at;
  }
  EXPECT_EQ(refused, 37);
}

// Somebody may be in the cell: the retract waits for the next start.
TEST(Procedure, MovesNothingAfterAStopUntilItIsStartedAgain) {
  int stopped = 0;
  for (int stop_at = 1; stop_at < 900; stop_at += 7, ++stopped) {
    IdealCell cell;
    cell.steps_left = stop_at;
    ProcedureRecord record;
    const auto done = carry_out(cell, rules(), record, kNobody);
    if (done) break;
    EXPECT_NE(done.error().message.find("the same command retracts it"), std::string::npos);
    EXPECT_EQ(cell.steps_after_stop, 0) << stop_at;
    cell.deepest_mm = -1e9;
    ASSERT_TRUE(carry_out(cell, rules(), record, kNobody)) << stop_at;
    EXPECT_LT(cell.deepest_mm, -0.5) << "retracted before the robot above travelled";
    EXPECT_EQ(record.indents.size(), 3U) << stop_at;
  }
  EXPECT_GT(stopped, 10);
}

// At any look, that is also after a contact was recorded and before the robot below was away.
TEST(Procedure, ListsEachContactOnceAndKeepsTheLineAfterARecordedOne) {
  for (int at = 0; at < 900; ++at) {
    IdealCell cell;
    cell.interrupted_at = at;
    ProcedureRecord record;
    if (carry_out(cell, rules(), record, kNobody)) break;
    const auto& list = record.contact_list;
    const bool is_lost = !list.empty() && !list.back().trouble.empty();
    EXPECT_EQ(record.aside_um, is_lost ? rules().retry_um : 0) << at;
    ASSERT_TRUE(carry_out(cell, rules(), record, kNobody)) << at;
    for (std::size_t i = 0; i < list.size(); ++i)
      EXPECT_EQ(list[i].touch.contact, static_cast<int>(i) + 1) << at;
  }
}

TEST(Procedure, IsRefusedWithAnotherToolThanItWasBegunWith) {
  IdealCell cell;
  ProcedureRecord record;
  record.tool = "diamond 2";
  EXPECT_EQ(carry_out(cell, rules(), record, kNobody).error().reason, "OTHER_TOOL");
  EXPECT_TRUE(cell.touched.empty());
}

// A retract lowers: the robot below stands at its home, 0, where the file's heights are above it.
TEST(Procedure, NeverRaisesTheRobotBelowBecauseTheOtherOneFailed) {
  IdealCell cell;
  cell.above_is_there = false;
  ProcedureRecord record;
  EXPECT_EQ(carry_out(cell, rules(), record, kNobody).error().reason, "NO_CHANNEL");
  EXPECT_EQ(cell.highest_mm, 0);
}

TEST(Procedure, SaysWhatToDoWhenNothingIsTouched) {
  IdealCell cell;
  ProcedureRecord record;
  auto low = rules();
  low.approach = {.depart_mm = 1, .highest_mm = 1.01};
  const auto done = carry_out(cell, low, record, kNobody);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "NOTHING_FOUND");
  EXPECT_EQ(record.contacts, 0);
  EXPECT_FALSE(record.in_contact);
}

// The three contacts of the alignment are not pressed: the common zero is the first that is.
TEST(Procedure, SaysThatAContactWasLostWhileItWasPressed) {
  IdealCell cell;
  cell.breaks_at_overlap_mm = 0.0006;
  auto pressed = rules();
  pressed.press_mm = 0.00075;
  ProcedureRecord record;
  const auto done = carry_out(cell, pressed, record, kNobody);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "CONTACT_LOST");
  EXPECT_NE(done.error().message.find("goes on, beside this place"), std::string::npos);
  EXPECT_EQ(record.stage, Stage::zero);
  EXPECT_FALSE(record.in_contact) << "retracted";
  EXPECT_GT(record.aside_um, 0) << "that surface is used";
  IdealCell mended;
  EXPECT_TRUE(carry_out(mended, pressed, record, kNobody));
  EXPECT_EQ(record.indents.size(), 3U);
}

}  // namespace
}  // namespace driftwise::indentation
