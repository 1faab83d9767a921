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
  double most_overlap_mm = -1e9;
  std::string source{};

  Result<Answer> move_above(double x_mm, double y_mm, double z_mm) override {
    if (auto ok = alive(); !ok) return tl::unexpected(std::move(ok).error());
    if (!above_is_there) return fail(ErrorCode::invalid_argument, reasons::kNoChannel, "no mm.q1");
    deepest_mm = std::max(deepest_mm, overlap_mm());
    x_ = x_mm;
    y_ = y_mm;
    above_z_ = z_mm;
    return Answer{"ideal", source};
  }
  Result<Answer> move_below(double rx_arcsec, double ry_arcsec, double z_mm) override {
    if (auto ok = alive(); !ok) return tl::unexpected(std::move(ok).error());
    if (steps_left < 0) ++steps_after_stop;
    if (steps_left-- == 0) return fail(ErrorCode::aborted, reasons::kRunAborted, "stopped by bob");
    rx_ = rx_arcsec;
    ry_ = ry_arcsec;
    z_ = z_mm;
    highest_mm = std::max(highest_mm, z_);
    most_overlap_mm = std::max(most_overlap_mm, overlap_mm());
    if (overlap_mm() > 0 && (touched.empty() || touched.back() != std::pair{x_, y_}))
      touched.emplace_back(x_, y_);
    return Answer{"ideal", source};
  }
  Result<Answer> retract_below(double rx_arcsec, double ry_arcsec, double z_mm) override {
    if (z_mm < z_) return move_below(rx_arcsec, ry_arcsec, z_mm);
    if (auto ok = alive(); !ok) return tl::unexpected(std::move(ok).error());
    return Answer{"ideal", source};
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
    return z_ - 0.6 - above_z_ + y_ * tangent(rx_ + tilt_rx_arcsec) -
           x_ * tangent(ry_ + tilt_ry_arcsec);
  }

 private:
  Result<void> alive() {
    if (calls_left-- > 0) return {};
    return fail(ErrorCode::unavailable, reasons::kLinkLost, "the daemon is away");
  }
  double x_ = 0, y_ = 0, above_z_ = 1, z_ = 0, rx_ = 0, ry_ = 0;
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

// The number of the contact goes back, and the record is younger all the same.
TEST(Procedure, SaysWhatToDoWhenNothingIsTouched) {
  IdealCell cell;
  ProcedureRecord record;
  auto low = rules();
  low.approach = {.depart_mm = 1, .highest_mm = 1.01};
  std::vector<std::int64_t> revisions;
  const auto keep = [&](const ProcedureRecord& now) -> Result<void> {
    revisions.push_back(now.revision);
    return {};
  };
  const auto done = carry_out(cell, low, record, keep);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "NOTHING_FOUND");
  EXPECT_EQ(record.contacts, 0);
  EXPECT_TRUE(record.contact_list.empty());
  EXPECT_FALSE(record.in_contact);
  EXPECT_EQ(revisions, (std::vector<std::int64_t>{1, 2})) << "before the approach, at the end";
  ASSERT_TRUE(carry_out(cell, rules(), record, keep));
  EXPECT_EQ(record.contact_list.front().touch.contact, 1) << "of what touched";
  for (std::size_t i = 1; i < revisions.size(); ++i)
    EXPECT_EQ(revisions[i], revisions[i - 1] + 1) << "each change is younger";
}

// The surface is at 1.6037 mm where the first touch is made; 1 to 20 um beyond it the tool is
// pressed in before anything can be looked at.
TEST(Procedure, TakesNoHeightFromAnApproachThatBeginsInContact) {
  for (const double beyond_um : {1.0, 2.0, 10.0, 20.0}) {
    IdealCell cell;
    ProcedureRecord record;
    auto high = rules();
    high.approach = {.depart_mm = 1.603665 + beyond_um * 1e-3, .highest_mm = 1.64};
    const auto done = carry_out(cell, high, record, kNobody);
    ASSERT_FALSE(done) << beyond_um;
    EXPECT_EQ(done.error().reason, "OUTSIDE_LIMITS") << beyond_um;
    EXPECT_NE(done.error().message.find("depart_mm lower"), std::string::npos)
        << done.error().message;
    EXPECT_TRUE(record.touches.empty()) << beyond_um;
    EXPECT_LT(cell.most_overlap_mm, 1e-3 * beyond_um + 1e-5) << "no step further";
    EXPECT_LT(cell.overlap_mm(), -0.5) << "retracted";
    ASSERT_EQ(record.contact_list.size(), 1U) << "the place is used, and marked";
    EXPECT_FALSE(record.contact_list.front().trouble.empty());
    ASSERT_TRUE(carry_out(cell, rules(), record, kNobody)) << "begun lower, it goes on";
    EXPECT_EQ(record.zero.contact, 8) << "the marked place has a number in the microscope";
  }
}

ProcedureRecord stopped_at(IdealCell& cell, Stage stage, std::size_t touches = 0) {
  ProcedureRecord record;
  const auto until = [&](const ProcedureRecord& now) -> Result<void> {
    if (now.stage == stage && now.touches.size() == touches && !now.in_contact)
      return fail(ErrorCode::cancelled, reasons::kCancelled, "Ctrl-C");
    return {};
  };
  EXPECT_EQ(carry_out(cell, rules(), record, until).error().message, "Ctrl-C");
  return record;
}

// The tool is 0.1 mm lower, so contacts are at 1.5 mm: with the heights of before the approach
// would begin 90 um inside the work-piece.
TEST(Procedure, TouchesAnewWhereTheRobotAboveStandsAtAnotherHeight) {
  for (const auto& [stage, touches] :
       {std::pair{Stage::align, 2U}, {Stage::zero, 0U}, {Stage::indents, 0U}}) {
    IdealCell cell;
    auto record = stopped_at(cell, stage, touches);
    auto lower = rules();
    lower.work_mm = 0.9;
    lower.approach = {.depart_mm = 1.48, .highest_mm = 1.53};
    const auto done = carry_out(cell, lower, record, kNobody);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_LT(cell.most_overlap_mm, 0.0005) << to_string(stage);
    EXPECT_NEAR(record.height_mm, 1.5, 0.002) << to_string(stage);
    EXPECT_EQ(record.indents.size(), 3U);
    auto places = cell.touched;
    std::ranges::sort(places);
    EXPECT_EQ(std::ranges::adjacent_find(places), places.end()) << "no place is used twice";
  }
}

TEST(Procedure, TouchesAnewWhereAnotherPlanMovesTheRobots) {
  IdealCell cell;
  cell.source = "plan 1";
  auto record = stopped_at(cell, Stage::zero);
  cell.source = "plan 2";
  ASSERT_TRUE(carry_out(cell, rules(), record, kNobody));
  EXPECT_GE(record.rounds.size(), 3U) << "aligned in the new plan's coordinates";
  EXPECT_TRUE(std::ranges::any_of(record.log, [](const std::string& line) {
    return line.find("moved by plan 1, now it is work_mm 1 and moved by plan 2") !=
           std::string::npos;
  }));
}

TEST(Procedure, EndsWhereAnotherPlanIsPromotedMeanwhile) {
  IdealCell cell;
  cell.source = "plan 1";
  ProcedureRecord record;
  const auto promote = [&](const ProcedureRecord& now) -> Result<void> {
    if (now.touches.size() == 2) cell.source = "plan 2";
    return {};
  };
  EXPECT_EQ(carry_out(cell, rules(), record, promote).error().reason, "CONFIGURATION_CHANGED");
  EXPECT_LT(cell.overlap_mm(), -0.5);
  EXPECT_TRUE(carry_out(cell, rules(), record, kNobody));
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
