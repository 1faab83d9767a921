#include "server/formats/export/target_line.h"

#include <gtest/gtest.h>

#include "server/compensation/snapshot_builder.h"
#include "tests/unit/compensation/models.h"
#include "tests/unit/plans/two_robots.h"

namespace driftwise::formats {
namespace {

using compensation::Variable;

TEST(ParseTargetLine, ReadsPoseForceAndTheWishForUncertainty) {
  const auto request = parse_target_line("TARGET  force_N=-2.5e1\tx_mm=1.5 rz_arcsec=0 u=1 ");
  ASSERT_TRUE(request) << request.error().message;
  EXPECT_EQ(request->value[static_cast<std::size_t>(Variable::x)], 1.5);
  EXPECT_EQ(request->value[static_cast<std::size_t>(Variable::force)], -25);
  EXPECT_EQ(request->given, bit(Variable::x) | bit(Variable::rz) | bit(Variable::force));
  EXPECT_TRUE(request->with_uncertainty);
  EXPECT_FALSE(parse_target_line("TARGET x_mm=1")->with_uncertainty);
}

struct TargetLineMistake {
  const char* name;
  const char* line;
  const char* reason;
  const char* says;
};
class BadTargetLine : public testing::TestWithParam<TargetLineMistake> {};
TEST_P(BadTargetLine, IsRefusedWithFoundAndExpected) {
  const auto request = parse_target_line(GetParam().line);
  ASSERT_FALSE(request);
  EXPECT_EQ(request.error().reason, GetParam().reason);
  EXPECT_TRUE(request.error().message.find(GetParam().says) != std::string::npos)
      << request.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadTargetLine,
    testing::Values(
        TargetLineMistake{"Nothing", "", "UNKNOWN_VERB", "found nothing, expected TARGET"},
        TargetLineMistake{"Verb", "target x_mm=1", "UNKNOWN_VERB", "found 'target'"},
        TargetLineMistake{"Http", "GET / HTTP/1.1", "UNKNOWN_VERB", "found 'GET'"},
        TargetLineMistake{"NoEquals", "TARGET x_mm", "BAD_WORD",
                          "found 'x_mm', expected name=value"},
        TargetLineMistake{"Name", "TARGET w_mm=1", "UNKNOWN_NAME", "found 'w_mm'"},
        TargetLineMistake{"Unit", "TARGET x_um=1", "UNKNOWN_NAME", "expected x_mm"},
        TargetLineMistake{"Twice", "TARGET x_mm=1 x_mm=1", "DUPLICATE_NAME", "'x_mm' twice"},
        TargetLineMistake{"Text", "TARGET x_mm=one", "BAD_NUMBER", "x_mm: found 'one'"},
        TargetLineMistake{"Empty", "TARGET x_mm=", "BAD_NUMBER", "x_mm: found ''"},
        TargetLineMistake{"Nan", "TARGET x_mm=nan", "BAD_NUMBER", "found 'nan'"},
        TargetLineMistake{"Huge", "TARGET x_mm=1e400", "BAD_NUMBER", "found '1e400'"},
        TargetLineMistake{"TwoSigns", "TARGET x_mm=+-1", "BAD_NUMBER", "found '+-1'"},
        TargetLineMistake{"SignAlone", "TARGET x_mm=+", "BAD_NUMBER", "found '+'"},
        TargetLineMistake{"Comma", "TARGET x_mm=1,5", "BAD_NUMBER", "found '1,5'"},
        TargetLineMistake{"Flag", "TARGET x_mm=1 u=yes", "BAD_FLAG",
                          "u: found 'yes', expected 0 or 1"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(ParseTargetLine, TakesANumberWithAPlusSignAsPrintfWritesIt) {
  const auto request = parse_target_line("TARGET x_mm=+1.5e-3 y_mm=+.5");
  ASSERT_TRUE(request) << request.error().message;
  EXPECT_EQ(request->value[0], 1.5e-3);
  EXPECT_EQ(request->value[1], 0.5);
}

TEST(ParseTargetLine, RefusesALineBeyondTheLimit) {
  EXPECT_EQ(parse_target_line("TARGET " + std::string(kMaxTargetLine, ' ')).error().reason,
            "LINE_TOO_LONG");
}

class TargetAnswer : public testing::Test {
 protected:
  TargetAnswer()
      : builder_(std::move(*compensation::SnapshotBuilder::create(
            compensation::axis_model(), ModelId{3}, compensation::axis_cell()))) {
    builder_.keep_model_datum();
    const ChannelValue t07{"t07_degC", 21};
    builder_.observe(std::span(&t07, 1), now_);
  }
  std::string answer(const std::string& line) {
    const auto snapshot = builder_.build(now_);
    std::string out;
    const auto request = *parse_target_line(line);
    append_target_answer(out, snapshot, compute_target(snapshot, request),
                         request.with_uncertainty);
    return out;
  }
  CellTime now_ = *parse_iso8601("2026-11-21T08:04:54Z");
  compensation::SnapshotBuilder builder_;
};

TEST_F(TargetAnswer, GivesCoordinateUncertaintyValidityModelAndFlags) {
  // 1 + 2 + 0.5 + 0.021 + 0.0042; the uncertainty is checked in target_test.cc
  const auto text = answer("TARGET x_mm=1 u=1");
  EXPECT_TRUE(text.starts_with("OK q1_mm=3.5252 u90_nm=")) << text;
  EXPECT_TRUE(text.ends_with(" valid_until=2026-11-21T08:05:04Z model=3 flags=-\n")) << text;
  EXPECT_EQ(answer("TARGET x_mm=1"),
            "OK q1_mm=3.5252 valid_until=2026-11-21T08:05:04Z model=3 flags=-\n");
}

TEST_F(TargetAnswer, NamesTheChannelOfAFlag) {
  EXPECT_TRUE(answer("TARGET x_mm=9").ends_with("flags=OUTSIDE_DOMAIN(x_mm)\n"));
}

TEST_F(TargetAnswer, RefusesWhatCannotBeReachedInOneWord) {
  EXPECT_EQ(
      answer("TARGET x_mm=-30"),
      "ERR OUTSIDE_LIMITS(q1) q1_mm = 390.895 lies beyond its soft limits -250 .. 250 mm: the "
      "pose cannot be reached; ask for one within the travel\n");
}

TEST_F(TargetAnswer, NamesWhatTheModelDoesNotKnow) {
  EXPECT_TRUE(answer("TARGET x_mm=1 rx_arcsec=0 force_N=2")
                  .ends_with("flags=IGNORED_COORDINATE(rx_arcsec+force_N)\n"));
}

TEST_F(TargetAnswer, SaysWhatIsMissingInOneLine) {
  EXPECT_EQ(answer("TARGET y_mm=1"),
            "ERR MISSING_COORDINATE the request lacks x_mm, which the model needs: state it, 0 "
            "included\n");
}

TEST(ErrorAnswer, StaysOneLineWhateverTheMessageHolds) {
  std::string out;
  append_error_answer(out, {ErrorCode::internal, "BUG", "two\nlines\r"});
  EXPECT_EQ(out, "ERR BUG two lines \n");
}

class JointLine : public testing::Test {
 protected:
  JointLine() {
    auto builder = *plans::JointBuilder::create(plans::joint_plan(), PlanId{7},
                                                plans::joint_models(), plans::two_robot_cell());
    builder.anchor({}, [](ModelId) { return true; });
    const ChannelValue values[] = {{"t05_degC", 20.5}, {"t09_degC", 20.0}};
    builder.observe(values, CellTime{1});
    snapshot = builder.build(CellTime{1});
  }
  std::string ask(const std::string& line) const {
    std::string out;
    auto request = parse_joint_line(line, snapshot);
    if (!request) {
      append_error_answer(out, request.error());
      return out;
    }
    request->now = CellTime{1};
    append_joint_answer(out, snapshot, plans::compute_joint_target(snapshot, *request),
                        request->with_uncertainty);
    return out;
  }
  plans::JointSnapshot snapshot;
};

TEST_F(JointLine, HoldsMotorsTermsAndModelsWithTheirUncertainty) {
  const std::string line =
      "JOINT mn.x_mm=1 mn.y_mm=0 mn.z_mm=0 ma.rx_arcsec=325 ma.ry_arcsec=0 ma.z_mm=3";
  const auto plain = ask(line);
  EXPECT_EQ(plain.substr(0, 14), "OK mn.q1_mm=1.") << plain;
  for (const char* part :
       {" ma.q3_mm=", " add_mn.x_mm=0.00", " add_ma.ry_arcsec=-20.0", " seen_mn.rz_arcsec=5.0",
        " by_mn=one:12 ", " by_ma=blend:11*", " plan=7 flags=BLENDED(ma)"})
    EXPECT_NE(plain.find(part), std::string::npos) << part << " in " << plain;
  EXPECT_EQ(plain.find("u90"), std::string::npos);
  const auto with = ask(line + " u=1");
  for (const char* part : {" u90_ma.q1_nm=", " u90_add_mn.x_nm=", " u90_add_ma.rx_arcsec=0.8225",
                           " u90_seen_mn.rz_arcsec=0.8225"})
    EXPECT_NE(with.find(part), std::string::npos) << part << " in " << with;
  EXPECT_EQ(with.back(), '\n');
}

TEST_F(JointLine, RefusesWhatItCannotMean) {
  EXPECT_TRUE(ask("JOINT mx.x_mm=1").starts_with("ERR UNKNOWN_NAME found 'mx.x_mm'"));
  EXPECT_TRUE(ask("JOINT mn.x_mm=1 mn.x_mm=1").starts_with("ERR DUPLICATE_NAME"));
  EXPECT_TRUE(ask("JOINT mn.x_mm=one").starts_with("ERR BAD_NUMBER"));
  EXPECT_TRUE(ask("JOINTS mn.x_mm=1").starts_with("ERR UNKNOWN_VERB"));
  EXPECT_TRUE(
      ask("JOINT mn.x_mm=1").starts_with("ERR MISSING_COORDINATE the request lacks mn.y_mm"));
  snapshot = {};
  EXPECT_TRUE(ask("JOINT any.x_mm=1").starts_with("ERR NO_PLAN"));
}

}  // namespace
}  // namespace driftwise::formats
