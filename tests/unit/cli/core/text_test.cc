#include "clients/cli/core/text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "clients/cli/core/assignment.h"
#include "clients/cli/core/console.h"
#include "clients/cli/core/table.h"
#include "clients/cli/pages/band_text.h"
#include "clients/cli/pages/progress_bar.h"

namespace driftwise::cli {
namespace {

TEST(Text, SpansAreReadAtAGlance) {
  EXPECT_EQ(span_text(0.0123), "12.3 ms");
  EXPECT_EQ(span_text(59.94), "59.9 s");
  EXPECT_EQ(span_text(61), "1 min 01 s");
  EXPECT_EQ(span_text(4 * 3600 + 150), "4 h 02 min");
  EXPECT_EQ(span_text(60 * 3600), "2 d 12 h");
  EXPECT_EQ(span_text(std::nan("")), "-");
}

TEST(Text, NumbersAreWholeAndFinite) {
  EXPECT_EQ(number_from("1.5e-3"), 1.5e-3);
  EXPECT_EQ(number_from("+2"), 2);
  for (const char* bad : {"", " 1", "1 ", "1,5", "0x10", "nan", "inf", "1e999", "--1"})
    EXPECT_FALSE(number_from(bad)) << bad;
  EXPECT_EQ(fixed(-0.0001, 2), "0.00");
  EXPECT_EQ(signed_fixed(-6e-11, 2), "0.00");
  EXPECT_EQ(signed_fixed(0.04, 1), "0.0");
  EXPECT_EQ(signed_fixed(0.06, 1), "+0.1");
}

TEST(Table, AlignsByCharactersNotBytes) {
  Table table({{"name"}, {"nm", Align::right}});
  table.add({"J\xc3\xbcrg", "12.0"});
  table.add({"ada", "-3.5"});
  std::ostringstream out;
  table.print(out, Paint(false));
  EXPECT_EQ(out.str(), "name    nm\nJ\xc3\xbcrg  12.0\nada   -3.5\n");
}

TEST(Assignment, KnowsTheUnitsOfCoordinates) {
  EXPECT_EQ(assignment_from("x=1.5").channel(), "x_mm");
  EXPECT_EQ(assignment_from("x=1.5mm").value(), 1.5);
  EXPECT_EQ(assignment_from("ry_arcsec=-12").channel(), "ry_arcsec");
  EXPECT_EQ(assignment_from("ma.rx=12").channel(), "ma.rx_arcsec");
  EXPECT_EQ(assignment_from("m_a.z_mm=3mm").channel(), "m_a.z_mm");
  EXPECT_EQ(assignment_from("F=0.3 N").channel(), "force_N");
  EXPECT_EQ(assignment_from("q1=0.25").channel(), "q1_mm");
  for (const char* bad : {"", "x", "=", "x=", "x_um=1", "t07=1", "x=1um", "x=1e999"})
    EXPECT_THROW(assignment_from(bad), Failure) << bad;
}

v1::RunProgress progress(std::int64_t accepted, std::int64_t rows) {
  v1::RunProgress p;
  p.mutable_run()->set_id(3);
  p.mutable_run()->set_state(v1::Run::STATE_RUNNING);
  p.mutable_run()->set_accepted_count(accepted);
  p.mutable_run()->set_row_count(rows);
  p.set_phase("moving");
  return p;
}

TEST(ProgressLine, ShowsTheShareAndWhatIsLeft) {
  auto p = progress(412, 1008);
  p.set_last_spread_nm(3.14);
  EXPECT_EQ(progress_line(p, 3725, 200),
            "run 3 moving [########............]  412/1008  40 %  1 h 02 min left  spread 3.1 nm");
}

TEST(ProgressLine, OfARunThatWaitsSaysWhatIsLeft) {
  auto p = progress(412, 1008);
  p.mutable_run()->set_state(v1::Run::STATE_WAITING);
  p.mutable_remaining_duration()->set_seconds(3725);
  p.mutable_estimated_end_time()->set_seconds(1'300'000'000);
  EXPECT_EQ(progress_line(p, 3725, 200),
            "run 3 waiting [########............]  412/1008  40 %  1 h 02 min of cell time left "
            "once it goes on");
}

TEST(ProgressLine, StatesTheEndAsABand) {
  auto p = progress(412, 1008);
  p.mutable_remaining_duration()->set_seconds(3725);
  // 2011-03-13, a Sunday, 07:06:40 UTC.
  p.mutable_estimated_end_time()->set_seconds(1'300'000'000);
  p.mutable_earliest_end_time()->set_seconds(1'300'000'000 - 1200);
  p.mutable_latest_end_time()->set_seconds(1'300'000'000 + 86'400);
  p.mutable_remaining_band()->set_share(0.8);
  EXPECT_EQ(progress_line(p, std::nan(""), 200),
            "run 3 moving [########............]  412/1008  40 %  ends Sun 07:06, 80 %: 06:46 to "
            "Mon 07:06 UTC");
}

TEST(BandText, SaysWhatItRestsOn) {
  v1::DurationBand band;
  band.mutable_low_duration()->set_seconds(3600);
  band.mutable_high_duration()->set_seconds(7200);
  band.set_share(0.8);
  EXPECT_EQ(band_text(band), "80 %: 1 h 00 min to 2 h 00 min; no run of this cell is on record");
  band.set_run_count(12);
  EXPECT_EQ(band_text(band), "80 %: 1 h 00 min to 2 h 00 min, from 12 runs of this cell");
}

// A device that comes and goes lets a run wait and go on a thousand times.
TEST(ProgressBarInALog, IsNotFloodedByARunThatWaitsAndGoesOn) {
  std::ostringstream out, err;
  const std::map<std::string, std::string> environment;
  const Console console{out, err, false, false, 80, environment, "", false, 24, nullptr, false};
  {
    ProgressBar bar(console, {});
    auto p = progress(412, 1008);
    for (int i = 0; i < 2000; ++i) {
      p.mutable_run()->set_state(i % 2 == 0 ? v1::Run::STATE_WAITING : v1::Run::STATE_RUNNING);
      bar.show(p);
    }
    p = progress(1008, 1008);
    p.mutable_run()->set_state(v1::Run::STATE_DONE);
    bar.show(p);
  }
  const std::string log = err.str();
  EXPECT_LE(std::ranges::count(log, '\n'), ProgressBar::kStatesAtOnce + 3);
  EXPECT_THAT(log, testing::HasSubstr("run 3 done"));
}

// A run stood for a day behind `run start --watch`, and the line said "waiting" alone.
TEST(ProgressBar, SaysWhatARunWaitsFor) {
  const std::string why = "the stabiliser support is at 22.500 degC, -0.500 K from its set-point";
  for (const bool terminal : {false, true}) {
    std::ostringstream out, err;
    const std::map<std::string, std::string> environment;
    const Console console{out, err,   terminal, terminal, 80,   environment,
                          "",  false, 24,       nullptr,  false};
    {
      ProgressBar bar(console, {});
      auto p = progress(0, 1008);
      p.mutable_run()->set_state(v1::Run::STATE_WAITING);
      bar.show(p);  // why is told a moment later, in the same state
      p.mutable_run()->set_reason(why);
      bar.show(p);
      bar.show(p);
    }
    const auto told = err.str();
    const auto at = told.find(why);
    ASSERT_NE(at, std::string::npos) << told;
    EXPECT_EQ(told.find(why, at + 1), std::string::npos) << "once";
  }
}

TEST(ProgressLine, FitsItsWidthAndNeverDividesByZero) {
  EXPECT_LE(width_of(progress_line(progress(412, 1008), 3725, 60)), 60U);
  EXPECT_EQ(progress_line(progress(0, 0), std::nan(""), 80),
            "run 3 moving [....................]  0/0  0 %");
  EXPECT_THAT(progress_line(progress(1008, 1008), std::nan(""), 80),
              testing::HasSubstr("[####################]"));
}

}  // namespace
}  // namespace driftwise::cli
