// `driftwise data join`: dataset files without a daemon, and runs of the record.

#include <algorithm>

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

// A line of 12 poses with returns to zero; x = q, y = 2 q, ry = 40 q, each with an offset.
std::string session_csv(const std::string& columns, double offset,
                        const std::string& tool = "cube") {
  std::ostringstream text;
  text << "# tool: " << tool << "\ntime_s,zero,q1_mm";
  for (const auto& name : {"x_mm", "y_mm", "ry_arcsec"})
    if (columns.find(name) != std::string::npos) text << ',' << name;
  text << ",t05_degC\n";
  for (int i = 0; i < 12; ++i) {
    const double q = i % 4 == 0 ? 0 : 0.25 * ((5 * i) % 12 - 6);
    // A deterministic wobble of the size of a reading's noise.
    const double wobble = 1e-6 * ((7 * i) % 5 - 2);
    text << 15 * i << ',' << (i % 4 == 0) << ',' << q;
    if (columns.find("x_mm") != std::string::npos) text << ',' << q + offset + wobble;
    if (columns.find("y_mm") != std::string::npos) text << ',' << 2 * q + offset + wobble;
    if (columns.find("ry_arcsec") != std::string::npos)
      text << ',' << 40 * q + 1000 * offset + 1e4 * wobble;
    text << ",20.5\n";
  }
  return text.str();
}

class JoinCommand : public CliTest {
 protected:
  std::string first() { return file("first.csv", session_csv("x_mm ry_arcsec", 0.001)); }
  std::string second() { return file("second.csv", session_csv("y_mm ry_arcsec", -0.002)); }
};

TEST_F(JoinCommand, JoinsFilesWithoutADaemon) {
  environment["DRIFTWISE_SERVER"] = "127.0.0.1:1";
  const auto said = run({"data", "join", first(), second(), "-o", folder.path() + "/joined.csv"});
  EXPECT_EQ(said.exit, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("12 rows joined"));
  EXPECT_THAT(said.out, HasSubstr("warning: lengths of"));
  const auto fitted =
      json({"fit", folder.path() + "/joined.csv", "--model", "q ~ x + y", "--select", "all"});
  EXPECT_EQ(fitted["rows"]["calibration"], 12);
  const auto piped = run({"data", "join", first(), second(), "-o", "-"});
  EXPECT_THAT(piped.out, HasSubstr("# joined: "));
  EXPECT_THAT(piped.out, HasSubstr("time_s,zero,q1_mm,x_mm,ry_arcsec,t05_degC,y_mm\n"));
}

// Rows 2, 6 and 10 of the first file are of a set with a name.
std::string with_a_set(const std::string& csv) {
  std::istringstream lines(csv);
  std::string out = "# time_zero: 2026-11-30T08:00:00Z\n# overruns: yes\n", line;
  for (int row = -1; std::getline(lines, line);) {
    if (line.starts_with('#')) {
      out += line + "\n";
      continue;
    }
    out += (row < 0 ? "set," : row % 4 == 2 ? "inside," : "calibration,") + line + "\n";
    ++row;
  }
  return out;
}

TEST_F(JoinCommand, KeepsWhatTheFirstFileSaysOfItsTimesAndSets) {
  const auto named = file("named.csv", with_a_set(session_csv("x_mm ry_arcsec", 0.001)));
  const auto joined = run({"data", "join", named, second(), "-o", "-"});
  ASSERT_EQ(joined.exit, 0) << joined.err;
  EXPECT_THAT(joined.out, HasSubstr("# time_zero: 2026-11-30T08:00:00Z\n"));
  EXPECT_THAT(joined.out, HasSubstr("# overruns: yes\n"));
  EXPECT_THAT(joined.out, HasSubstr("\n30,inside,"));
  EXPECT_THAT(joined.out, HasSubstr("\n15,calibration,"));
  const auto without = run({"data", "join", named, second(), "--subtract-returns", "-o", "-"});
  EXPECT_THAT(without.out, HasSubstr("\n90,inside,")) << "rows are counted with the returns";
}

// A passage before row 2 of the file, and row 5 was given up.
std::string with_a_passage(const std::string& csv) {
  std::istringstream lines(csv);
  std::string out = "# trajectory_rows: 1-4,6-13\n", line;
  for (int row = -1; std::getline(lines, line);) {
    if (line.starts_with('#')) {
      out += line + "\n";
      continue;
    }
    if (row == 1)
      out += "1,calibration,10,0,0" +
             std::string(static_cast<std::size_t>(std::ranges::count(line, ',')) - 3, ',') + "\n";
    out += (row < 0 ? "passage," : "0,") + line + "\n";
    ++row;
  }
  return out;
}

TEST_F(JoinCommand, OfImportedRunsKeepsSetsAndRowsBesideAPassage) {
  const auto with = [](const std::string& columns, double offset) {
    return with_a_passage(with_a_set(session_csv(columns, offset)));
  };
  for (const auto& csv : {with("x_mm ry_arcsec", 0.001), with("y_mm ry_arcsec", -0.002)})
    ASSERT_EQ(run({"data", "import", file("part.csv", csv)}).exit, 0);
  const auto joined = run({"data", "join", "1", "2"});
  ASSERT_EQ(joined.exit, 0) << joined.err;
  const auto out = run({"data", "export", "3"}).out;
  EXPECT_THAT(out, HasSubstr("# trajectory_rows: 1-4,6-13\n"));
  EXPECT_THAT(out, HasSubstr("\n30,inside,")) << out;
  EXPECT_THAT(out, HasSubstr("\n15,calibration,"));
}

TEST_F(JoinCommand, AngleDriftKeepsSetsAndCountsTheAnglesItEmpties) {
  auto csv = with_a_set(session_csv("x_mm ry_arcsec", 0.001));
  const auto last = csv.rfind(",20.5\n");
  csv.replace(last, 6, ",\n");
  const auto out = folder.path() + "/calm.csv";
  const auto said =
      run({"data", "angle-drift", file("named.csv", csv), "--channel", "ry", "--thermometer", "t05",
           "--arcsec-per-k", "2", "--u", "0.1", "--source", "drawing 17", "-o", out});
  ASSERT_EQ(said.exit, 0) << said.err;
  EXPECT_THAT(said.err, HasSubstr("1 rows have no ry there: t05 was not measured in them"));
  std::ifstream kept(out);
  EXPECT_THAT(std::string(std::istreambuf_iterator<char>(kept), {}), HasSubstr("\n30,inside,"));
}

TEST_F(JoinCommand, ReportsTheCheckOfACoordinateThatWasSeenTwice) {
  const auto report = json({"data", "join", first(), second(), "--dry-run"})["report"];
  EXPECT_EQ(report["rows"], 12);
  const auto& channels = report["channels"];
  const auto ry =
      std::ranges::find_if(channels, [](const auto& c) { return c["channel"] == "ry_arcsec"; });
  ASSERT_NE(ry, channels.end());
  EXPECT_EQ((*ry)["check"]["rows"], 12);
  EXPECT_NEAR((*ry)["check"]["median_arcsec"].get<double>(), 0, 1e-9);  // zeros are aligned
}

TEST_F(JoinCommand, RefusesWhatDoesNotBelongTogether) {
  const auto other = file("other.csv", session_csv("y_mm ry_arcsec", 0, "weight"));
  const auto refused = run({"data", "join", first(), other, "--dry-run"});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_THAT(refused.err, HasSubstr("with tool 'cube'"));
  auto moved = session_csv("y_mm ry_arcsec", 0);
  const auto value = moved.find("\n15,0,") + 6;  // of q1_mm in row 2
  moved.replace(value, moved.find(',', value) - value, "1");
  const auto apart = run({"data", "join", first(), file("moved.csv", moved), "--dry-run"});
  EXPECT_EQ(apart.exit, 3);
  EXPECT_THAT(apart.err, HasSubstr("row 2: q1_mm is "));
}

TEST_F(JoinCommand, SaysWhatItCannotDo) {
  EXPECT_EQ(run({"data", "join", first(), second()}).exit, 2);             // where to?
  EXPECT_EQ(run({"data", "join", first(), "3", "-o", "-"}).exit, 2);       // a file and a run
  EXPECT_EQ(run({"data", "join", "1", "2", "-o", "joined.csv"}).exit, 2);  // a run is stored
  EXPECT_EQ(run({"data", "join", first(), "-o", "-"}).exit, 3);            // one is none
  EXPECT_EQ(run({"data", "join", "1", "2"}).exit, 3);                      // no such runs
}

TEST_F(JoinCommand, CorrectsALengthByTheAnglesOfAnotherFile) {
  const auto lengths = file("x.csv", session_csv("x_mm", 0));
  const auto correction =
      file("beams.toml",
           "[correction]\n[[correction.beam]]\nlength = \"x_mm\"\noffset_mm = [0.0, 0.0, 10.0]\n");
  const auto piped =
      run({"data", "join", lengths, second(), "--correction", correction, "-o", "-"});
  EXPECT_EQ(piped.exit, 0) << piped.err;
  // Row 2: q = -0.25 mm, so ry = -10 arcsec; 10 mm of lever take 10 mm x -4.848e-5 off x.
  std::istringstream lines(piped.out);
  std::string line;
  double x = 0;
  while (std::getline(lines, line))
    if (line.starts_with("15,0,")) {
      std::istringstream fields(line);
      std::string field;
      for (int i = 0; i < 4; ++i) std::getline(fields, field, ',');
      x = std::stod(field);
    }
  EXPECT_NEAR(x, -0.25 + 10 * 10 * 4.8481368e-6, 5e-6);
}

TEST_F(JoinCommand, JoinsRunsIntoARun) {
  ASSERT_EQ(run({"data", "import", first()}).exit, 0);
  ASSERT_EQ(run({"data", "import", second()}).exit, 0);
  const auto checked = run({"data", "join", "1", "2", "--dry-run"});
  EXPECT_EQ(checked.exit, 0) << checked.err;
  EXPECT_THAT(checked.out, HasSubstr("run 1, run 2"));
  const auto joined = json({"data", "join", "1", "2", "--name", "both"});
  EXPECT_EQ(joined["run"]["name"], "both");
  EXPECT_EQ(joined["run"]["metadata"][0]["value"], "1, 2");
  const auto csv =
      run({"data", "export", std::to_string(std::stoll(joined["run"]["id"].dump()))}).out;
  EXPECT_THAT(csv, HasSubstr("# join_ry_arcsec: mean of run 1, run 2; u "));
}

}  // namespace
}  // namespace driftwise::tests
