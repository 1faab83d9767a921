// The cell against its description, thermometers side by side, a cell at rest, looking back, and
// the archive for people outside.

#include "server/application/commissioning/commissioning.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>

#include "server/application/look_back/look_back.h"
#include "server/application/support/support_bundles.h"
#include "server/formats/text/gzip.h"
#include "tests/support/cell_in_memory.h"
#include "tests/support/sql_query.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

using application::CheckItem;
using application::Finding;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

class AtCommissioning : public testing::Test {
 protected:
  Folder folder;
  SmallWorld world;
  std::optional<CellInMemory> cell_;
  CellDescription description = small_cell(folder / "cell.sqlite");

  // The laser is read by runs, and between them without being stored.
  AtCommissioning() { description.devices[2].period_s = 0; }
  CellInMemory& cell() {
    if (!cell_) cell_.emplace(world, description, kSqlite, kWorldBegin);
    return *cell_;
  }
  application::CellCheck checked() {
    cell().pass(20);
    return cell().await(cell()->commissioning.check(cell().ada));
  }
  static CheckItem item(const application::CellCheck& check, const std::string& device,
                        const std::string& asked) {
    for (const auto& one : check.items)
      if (one.device == device && one.asked == asked) return one;
    ADD_FAILURE() << "nothing was asked of " << device << " as " << asked;
    return {};
  }
};

TEST_F(AtCommissioning, EveryDeviceIsAskedAndComparedWithWhatIsDeclared) {
  description.devices[2].become<LengthSettings>().u_length_nm = 2;
  description.certificates = {{"laser-x", "4711", "PTB", "2025-03-01", "2027-03-01"},
                              {"scanner", "T-12", "a laboratory", "2020-01-01", "2022-01-01"}};
  const auto check = checked();
  EXPECT_EQ(item(check, "axis", "answer").finding, Finding::good);
  EXPECT_EQ(item(check, "axis", "reference").finding, Finding::warning) << "not homed yet";
  EXPECT_EQ(item(check, "axis", "identity").finding, Finding::unknown) << "none is declared";
  EXPECT_EQ(item(check, "laser-x", "range of x_mm").finding, Finding::good);
  const auto spread = item(check, "laser-x", "resolution of x_mm");
  EXPECT_EQ(spread.finding, Finding::good) << spread.found;
  EXPECT_THAT(spread.expected, HasSubstr("declared 2 nm"));
  EXPECT_EQ(item(check, "laser-x", "time of the reading").finding, Finding::good);
  EXPECT_EQ(item(check, "laser-x", "certificate").finding, Finding::good);
  EXPECT_EQ(item(check, "scanner", "range of t03_degC").finding, Finding::good);
  EXPECT_EQ(item(check, "scanner", "certificate").finding, Finding::warning);
  EXPECT_THAT(item(check, "scanner", "certificate").expected, HasSubstr("days overdue"));
  EXPECT_EQ(check.worst(), Finding::warning);
  EXPECT_EQ(world.moves, 0);
}

TEST_F(AtCommissioning, SaysWhatIsWrongAndWhatToDo) {
  description.devices[0].identity = "C-887";
  world.laser_away = true;
  world.probe_broken = true;
  const auto check = checked();
  const auto identity = item(check, "axis", "identity");
  EXPECT_EQ(identity.finding, Finding::bad);
  EXPECT_EQ(identity.expected, "contains 'C-887'");
  EXPECT_EQ(item(check, "laser-x", "answer").finding, Finding::bad);
  EXPECT_THAT(item(check, "laser-x", "answer").advice, HasSubstr("power, cable and address"));
  EXPECT_EQ(item(check, "scanner", "range of t03_degC").finding, Finding::bad);
  EXPECT_EQ(check.worst(), Finding::bad);
}

// The keeper asks every device who it is: the alarm came and went every few seconds.
TEST_F(AtCommissioning, ADeviceThatSaysWhoItIsAndGivesNoReadingStaysLost) {
  const auto link = [this] {
    for (const auto& device : cell().status().devices)
      if (device.description.id == "laser-x") return device.health.link;
    return LinkState::disconnected;
  };
  cell().pass(20);
  world.laser_mute = true;
  for (int i = 0; i < 60; ++i) {
    cell().pass(5);
    EXPECT_EQ(link(), LinkState::failed);
  }
  EXPECT_THAT(cell().events_named("device.lost"), SizeIs(1));
  EXPECT_THAT(cell().events_named("device.back"), SizeIs(0));
  world.laser_mute = false;
  cell().pass(10);
  EXPECT_EQ(link(), LinkState::connected);
  EXPECT_THAT(cell().events_named("device.back"), SizeIs(1));
}

TEST_F(AtCommissioning, AnInstrumentWhoseAnswersAreEqualHasNoSmallestStep) {
  world.noise_nm = world.nm_per_k = world.holding_nm = 0;
  EXPECT_THAT(item(checked(), "laser-x", "resolution of x_mm").found, HasSubstr("all equal"));
}

TEST_F(AtCommissioning, ANoisyInstrumentIsComparedWithTheGate) {
  world.noise_nm = 40;
  EXPECT_EQ(item(checked(), "laser-x", "resolution of x_mm").finding, Finding::bad);
}

TEST_F(AtCommissioning, AnOverdueCertificateIsANoticeAndAttention) {
  description.certificates = {{"laser-x", "4711", "PTB", "2020-03-01", "2022-03-01"}};
  cell().pass(30);
  EXPECT_THAT(cell().alarms_of("certificate.overdue"), SizeIs(1));
  EXPECT_THAT(
      cell().status().attention,
      testing::Contains(HasSubstr("certificate 4711 of laser-x (PTB) was due on 2022-03-01")));
  const auto states = cell()->commissioning.certificates();
  ASSERT_THAT(states, SizeIs(1));
  EXPECT_LT(*states.front().days_left, -1000);
}

TEST_F(AtCommissioning, ThermometersAreComparedOverTheRecord) {
  world.warming_k_per_h = 0;
  cell().pass(1800);
  const auto to = cell().now();
  const CellTime from{to.utc_ns - 1500'000'000'000};
  const auto report = cell().await(cell()->commissioning.compare_thermometers(from, to, {}));
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(report->quiet);
  ASSERT_THAT(report->comparison.offsets, SizeIs(5));
  // t0n = 20 + n / 10: no two of them agree.
  for (std::size_t n = 1; n < 5; ++n)
    EXPECT_NEAR(report->comparison.offsets[n].offset_k - report->comparison.offsets[n - 1].offset_k,
                0.1, 0.01);
  EXPECT_TRUE(report->comparison.offsets[0].out);
  EXPECT_EQ(cell()
                .await(cell()->commissioning.compare_thermometers(from, to, {"t77_degC"}))
                .error()
                .reason,
            "BAD_CHANNEL");
  EXPECT_EQ(cell().await(cell()->commissioning.compare_thermometers(to, from, {})).error().reason,
            "BAD_RANGE");
  EXPECT_EQ(cell()
                .await(cell()->commissioning.compare_thermometers(
                    from, {from.utc_ns + 60'000'000'000}, {}))
                .error()
                .reason,
            "TOO_FEW_SAMPLES");
}

TEST_F(AtCommissioning, ARestRecordsTheLengthsAndSaysSinceWhenTheCellIsWarm) {
  world.warming_k_per_h = 0;
  auto& running = cell();
  EXPECT_EQ(running.await(running->commissioning.rest()).error().reason, "NO_REST");
  ASSERT_TRUE(running.await(running->commissioning.begin_rest(running.ada, {20, 0.5, 600})));
  running.pass(3600);
  auto report = running.await(running->commissioning.rest());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_THAT(report->channels, SizeIs(6)) << "one length, five thermometers";
  EXPECT_EQ(report->channels.back().channel, "x_mm");
  ASSERT_TRUE(report->warm) << report->sentence;
  EXPECT_THAT(report->sentence, HasSubstr("warm since 08:"));
  ASSERT_TRUE(running.await(running->commissioning.end_rest(running.ada)));
  running.pass(600);
  EXPECT_EQ(running.await(running->commissioning.rest())->end_reason, "ended by ada");
  // Lengths are stored while the cell rests, and not afterwards; the air beside them every 20 s.
  const auto at_rest = running.await(running.read([end = report->begin](Store& store) {
    return store.readings().readings("laser-x", end, {end.utc_ns + 7200'000'000'000}, 0);
  }));
  ASSERT_TRUE(at_rest);
  const auto lengths = std::count_if(at_rest->begin(), at_rest->end(), [](const Reading& one) {
    return std::any_of(one.values.begin(), one.values.end(),
                       [](const auto& value) { return value.channel == "x_mm"; });
  });
  EXPECT_NEAR(static_cast<double>(lengths), 1800, 30);
  EXPECT_NEAR(static_cast<double>(std::ssize(*at_rest) - lengths), 600.0 / 20, 2);
}

TEST_F(AtCommissioning, ACellThatWarmsIsNotWarm) {
  world.warming_k_per_h = 2;
  auto& running = cell();
  ASSERT_TRUE(running.await(running->commissioning.begin_rest(running.ada, {20, 0.05, 600})));
  running.pass(2400);
  const auto report = running.await(running->commissioning.rest());
  EXPECT_FALSE(report->warm);
  EXPECT_THAT(report->sentence, HasSubstr("not warm yet"));
  EXPECT_NEAR(*report->channels.front().rate, 2, 0.1);
}

TEST_F(AtCommissioning, AMovementEndsTheRest) {
  auto& running = cell();
  ASSERT_TRUE(running.await(running->commissioning.begin_rest(running.ada, {})));
  running.pass(60);
  ASSERT_TRUE(running.await(running->manual.home(running.ada, running.lease())));
  running.pass(5);
  EXPECT_EQ(running.await(running->commissioning.rest())->end_reason, "an axis was moved by hand");
  EXPECT_EQ(running.await(running->commissioning.end_rest(running.ada)).error().reason, "NO_REST");
  EXPECT_EQ(
      running.await(running->commissioning.begin_rest(running.ada, {20, 0.05, 1})).error().reason,
      "BAD_LIMITS");
}

TEST_F(AtCommissioning, ARestThatIsBegunAnewHasAnEndOnRecord) {
  auto& running = cell();
  ASSERT_TRUE(running.await(running->commissioning.begin_rest(running.ada, {})));
  const auto first = *running.await(running.read([](Store& s) { return s.rests().newest_rest(); }));
  running.pass(60);
  ASSERT_TRUE(running.await(running->commissioning.begin_rest(running.ada, {})));
  running.pass(5);
  ASSERT_TRUE(running.await(running->commissioning.end_rest(running.ada)));
  const auto sql = "SELECT count(*) FROM rest WHERE ended_ns = 0";
  EXPECT_EQ(count_of(folder / "cell.sqlite", sql), 0) << "rest " << first->id << " has no end";
}

TEST_F(AtCommissioning, TheStabilityOfAChannelIsReadFromTheRecord) {
  world.warming_k_per_h = 0;
  auto& running = cell();
  running.pass(3600);
  const auto to = running.now();
  const CellTime from{to.utc_ns - 3500'000'000'000};
  const auto found = running.await(running->look_back.stability_of("t02_degC", from, to));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->unit, "mK");
  EXPECT_EQ(found->interval_s, 5) << "the scanner's period";
  EXPECT_GT(found->allan.size(), 5U);
  EXPECT_FALSE(found->spectrum.empty());
  EXPECT_EQ(running.await(running->look_back.stability_of("t99_degC", from, to)).error().reason,
            "NO_SUCH_CHANNEL");
  const auto refused = running.await(running->look_back.stability_of("x_mm", from, to)).error();
  EXPECT_EQ(refused.reason, "TOO_FEW_SAMPLES")
      << "lengths are not recorded while nobody lets the cell rest";
  EXPECT_THAT(refused.message, HasSubstr("x_mm from 20")) << "what was asked";
  EXPECT_THAT(refused.message, HasSubstr("expected at least 16"));
  EXPECT_THAT(refused.message, HasSubstr("driftwise align rest"));
  const CellTime short_before{to.utc_ns - 30'000'000'000};
  const auto few = running.await(running->look_back.stability_of("t02_degC", short_before, to));
  ASSERT_FALSE(few);
  EXPECT_THAT(few.error().message, HasSubstr("name a longer time (--hours)"));
}

TEST_F(AtCommissioning, RunsAreComparedOverTheirOwnHours) {
  auto& running = cell();
  running.begin_run(lines_of(3, {2, -3, 1}, true));
  const auto first = running.finish_run().id;
  world.warming_k_per_h = 3;
  running.begin_run(lines_of(3, {2, -3, 1}, true));
  const auto second = running.finish_run().id;
  const auto compared = running.await(running->look_back.compare({first, second}, std::nullopt));
  ASSERT_TRUE(compared) << compared.error().message;
  ASSERT_THAT(*compared, SizeIs(2));
  ASSERT_THAT((*compared)[0].zero, SizeIs(1));
  EXPECT_EQ((*compared)[0].zero.front().name, "x");
  EXPECT_EQ((*compared)[0].zero.front().unit, "nm");
  EXPECT_EQ((*compared)[0].zero.front().values.front(), 0);
  ASSERT_THAT((*compared)[1].temperatures, SizeIs(testing::Ge(5)));
  EXPECT_GT((*compared)[1].temperatures.front().range, 0.001);
  EXPECT_EQ(running.await(running->look_back.compare({}, std::nullopt)).error().reason,
            "BAD_COUNT");
}

TEST_F(AtCommissioning, ARemarkIsPinnedToAnInstantOnce) {
  auto& running = cell();
  running.pass(60);
  TimeNoteRecord note;
  note.about = {kWorldBegin.utc_ns + 10'000'000'000};
  note.text = "door open";
  note.request = "r1";
  const auto first = running.await(running->look_back.add_note(running.ada, note));
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(running.await(running->look_back.add_note(running.ada, note))->id, first->id);
  const auto notes = running.await(running.read([](Store& store) {
    return store.remarks().time_notes(CellTime{0}, {kWorldBegin.utc_ns + 3600'000'000'000}, 10);
  }));
  ASSERT_THAT(*notes, SizeIs(1));
  EXPECT_EQ(notes->front().who, "ada");
  note.channel = "t99_degC";
  note.request = "";
  EXPECT_EQ(running.await(running->look_back.add_note(running.ada, note)).error().reason,
            "BAD_SUBJECT");
}

// Secrets in every place that can hold one; none of them may be in the archive.
TEST_F(AtCommissioning, ASupportBundleHoldsNoSecret) {
  const auto write = [this](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return folder / name;
  };
  const std::string pem =
      "-----BEGIN PRIVATE KEY-----\nMIIpemSecretLine1\nMIIpemSecretLine2\n"
      "-----END PRIVATE KEY-----\n";
  description.text =
      "# a comment with commentSecret\n[cell]\nname = \"small\"\n"
      "[access]\nkey = \"server.key\"\n"
      "[[notify]]\nname = \"duty\"\nwebhook = \"https://hooks.example.org/T000/urlSecret?x=1\"\n"
      "token_file = \"hook.token\"\n"
      "[[notify]]\nname = \"mail\"\nsmtp = \"smtps://joe:smtpSecret@mail.example.org:465\"\n"
      "user = \"joe\"\npassword_file = \"mail.password\"\n"
      "[[notify]]\nname = \"chat\"\ncommand = [\"/usr/bin/apprise\", \"tgram://commandSecret\"]\n"
      "[[device]]\nid = \"ups\"\n[device.options]\npassword = \"optionSecret\"\nunits = \"K\"\n";
  description.access.key = write("server.key", pem);
  ReceiverDescription duty;
  duty.name = "duty";
  duty.token_file = write("hook.token", "tokenFileSecret\n");
  duty.password_file = write("mail.password", "mailPasswordSecret\n");
  description.receivers = {duty};
  write("driftwised.token", "dwt_bootSecret0123456789\n");
  auto& running = cell();
  running.pass(20);
  // A device, or a person, may say anything.
  ASSERT_TRUE(running.await(running->queue.hold(
      running.ada,
      "seen: Bearer bearerSecret99, dwt_eventSecret0123456789, https://joe:userSecret@host/, "
      "password=wordSecret, tokenFileSecret")));
  running.pass(5);
  const auto bytes = running.await(running->support.make(running.ada));
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_LT(bytes->size(), application::SupportBundles::kMostBytes);
  const auto tar = formats::gunzip(*bytes, "bundle", 64U << 20U);
  ASSERT_TRUE(tar);
  for (const char* secret :
       {"commentSecret", "urlSecret", "smtpSecret", "commandSecret", "optionSecret", "pemSecret",
        "mailPasswordSecret", "bootSecret", "bearerSecret", "eventSecret", "userSecret",
        "wordSecret", "tokenFileSecret"})
    EXPECT_THAT(*tar, Not(HasSubstr(secret))) << secret;
  for (const char* kept : {"driftwise-support/cell.toml", "ustar", "https://hooks.example.org",
                           "units = ", "schema ", "daemon.started", "t01_degC"})
    EXPECT_THAT(*tar, HasSubstr(kept)) << kept;
}

}  // namespace
}  // namespace driftwise::tests
