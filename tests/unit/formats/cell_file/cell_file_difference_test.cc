// Two cell files by meaning: what asks for a person, what is recorded only, what is the same.

#include "server/formats/cell_file/cell_file_difference.h"

#include <gmock/gmock.h>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"

namespace driftwise::formats {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

const std::string kDifferenceCell = R"(
[cell]
name = "bench"
database = "bench.db"
listen = "127.0.0.1:50051"

[run]
max_spread_nm = 5

[correction]
cosine = true
[[correction.beam]]
length = "x_mm"
offset_mm = [0, 12.5, 0]

[kinematics]
kind = "linear-axis"
[[kinematics.axis]]
motor = "q1_mm"
pose = "x_mm"

[[device]]
id = "axis"
kind = "pi-gcs"
address = "10.0.0.1:50000"
  [[device.axis]]
  channel = "q1_mm"
  device_axis = "X"
  min_mm = -4.5
  max_mm = 4.5

[[device]]
id = "scanner"
kind = "keithley-2701"
address = "10.0.0.2:1394"
  [[device.probe]]
  channel = "t07_degC"
  input = 107
  part = "robot"
  [[device.probe]]
  channel = "t08_degC"
  input = 108
  part = "instrument"
  place = "beam splitter"

[[device]]
id = "laser-x"
kind = "interferometer-adapter"
address = "10.0.0.3:5001"
length = "x_mm"
u_length_nm = 4.6

[[device]]
id = "laser-y"
kind = "interferometer-adapter"
address = "10.0.0.3:5002"
length = "y_mm"

[[device]]
id = "tilts"
kind = "newport-lds1000"
address = "10.0.0.4:4000"
  [[device.angle]]
  channel = "ry_arcsec"
  device_axis = 1
  [[device.angle]]
  channel = "rz_arcsec"
  device_axis = 2

[[device]]
id = "tilts-x"
kind = "newport-lds1000"
address = "10.0.0.5:4000"
  [[device.angle]]
  channel = "rx_arcsec"
  device_axis = 1
)";

std::string text_with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::vector<ConfigurationChange> changes_to(const std::string& after,
                                            const std::string& before = kDifferenceCell) {
  const auto cell = parse_cell_file(after, "cell.toml", drivers::all_devices());
  EXPECT_TRUE(cell) << (cell ? "" : cell.error().message);
  return cell ? cell_file_difference(before, *cell) : std::vector<ConfigurationChange>();
}

std::vector<std::string> sentences_of(const std::vector<ConfigurationChange>& all) {
  std::vector<std::string> out;
  for (const auto& one : all) out.push_back((one.asks ? "! " : "") + sentence(one));
  return out;
}

TEST(CellFileDifference, ShowsNoSecretOfEitherFile) {
  const std::string chat = "[[notify]]\nname = \"chat\"\ncommand = [\"/bin/send\", \"hush1\"]\n";
  const std::string duty = "[[notify]]\nname = \"duty\"\nwebhook = \"https://a.example/hush2\"\n";
  const std::string night =
      "[[notify]]\nname = \"night\"\nwebhook = \"https://b.example/hush3\"\n"
      "token_file = \"hook.token\"\n";
  const auto changes = changes_to(kDifferenceCell + text_with(chat, "hush1", "hush4") +
                                      text_with(duty, "hush2", "hush5") + night,
                                  kDifferenceCell + chat + duty);
  const auto said = sentences_of(changes);
  for (const auto& one : said) EXPECT_THAT(one, testing::Not(HasSubstr("hush")));
  EXPECT_THAT(said, testing::IsSupersetOf(
                        {std::string("notify chat: command [removed] -> [removed]"),
                         std::string("notify duty: webhook https://a.example/[removed] -> "
                                     "https://a.example/[removed]")}));
  EXPECT_THAT(said, testing::Contains(HasSubstr("notify night: new: ")));
  EXPECT_EQ(read_changes_json(write_changes_json(changes)), changes) << "nothing to remove twice";
}

TEST(CellFileDifference, RemovesTheSecretsThatAnEarlierProgramStored) {
  const auto read = read_changes_json(write_changes_json(
      {{"notify duty", "webhook", "https://a.example/hush", "https://b.example/hush", false, {}},
       {"notify chat", "", "", "command [/bin/send, hush], name chat", false, {}}}));
  EXPECT_EQ(sentences_of(read),
            (std::vector<std::string>{"notify duty: webhook https://a.example/[removed] -> "
                                      "https://b.example/[removed]",
                                      "notify chat: new: [removed]"}));
}

TEST(CellFileDifference, IsNoneByMeaning) {
  EXPECT_THAT(changes_to("# a comment\n" + kDifferenceCell), IsEmpty());
  EXPECT_THAT(changes_to(text_with(kDifferenceCell, "max_spread_nm = 5", "max_spread_nm = 5.0")),
              IsEmpty());
  EXPECT_THAT(changes_to(text_with(kDifferenceCell, "input = 107", "input = 107\n  r0_ohm = 1000")),
              IsEmpty())
      << "a default that is written out";
  EXPECT_THAT(changes_to(text_with(kDifferenceCell, "[run]",
                                   "[plausibility]\ngeometry_um = 20.0\n"
                                   "closure_nm_per_min = 60\n[run]")),
              IsEmpty())
      << "the same";
  // Another order of the devices and of the probes.
  auto moved = kDifferenceCell;
  const auto probe = moved.find("  [[device.probe]]\n  channel = \"t07_degC\"");
  const auto next = moved.find("  [[device.probe]]", probe + 5);
  const std::string t07 = moved.substr(probe, next - probe);
  moved.erase(probe, next - probe);
  const auto end = moved.find("place = \"beam splitter\"\n") + 24;
  moved.insert(end, t07);
  EXPECT_THAT(changes_to(moved), IsEmpty());
}

TEST(CellFileDifference, RecordsPortsRulesAndNamesOnly) {
  auto after = text_with(kDifferenceCell, "10.0.0.2:1394", "10.0.0.2:1395");
  after = text_with(after, "127.0.0.1:50051", "127.0.0.1:50052");
  after = text_with(after, "max_spread_nm = 5", "max_spread_nm = 6");
  after = text_with(after, "name = \"bench\"", "name = \"bench 2\"");
  const auto found = changes_to(after);
  EXPECT_THAT(sentences_of(found),
              UnorderedElementsAre("device scanner: port 1394 -> 1395",
                                   "cell: listen 127.0.0.1:50051 -> 127.0.0.1:50052",
                                   "run: max_spread_nm 5 -> 6", "cell: name bench -> bench 2"));
  EXPECT_FALSE(any_asks(found));
  EXPECT_THAT(found.front().affects, IsEmpty());
}

TEST(CellFileDifference, RecordsADoorThatIsOpened) {
  EXPECT_THAT(sentences_of(changes_to(text_with(
                  kDifferenceCell, "[run]",
                  "[access]\nplain_target_line = \"127.0.0.1:0\"\nplain_interface = \"lo\"\n"
                  "plain_allow = [\"127.0.0.1\"]\n[run]"))),
              ElementsAre(AllOf(HasSubstr("access: "), HasSubstr("plain_allow [127.0.0.1]"),
                                testing::Not(testing::StartsWith("! ")))));
}

TEST(CellFileDifference, TwoThermometersExchangedAsk) {
  auto after = text_with(text_with(kDifferenceCell, "input = 107", "input = 0"), "input = 108",
                         "input = 107");
  after = text_with(after, "input = 0", "input = 108");
  const auto found = changes_to(after);
  EXPECT_THAT(sentences_of(found), ElementsAre("! probe t07_degC: input 107 -> 108",
                                               "! probe t08_degC: input 108 -> 107"));
  EXPECT_THAT(found[0].affects, ElementsAre("t07"));
  EXPECT_EQ(read_changes_json(write_changes_json(found)), found);
}

TEST(CellFileDifference, TwoInstrumentsExchangedByTheirAddressesAsk) {
  auto after = text_with(text_with(kDifferenceCell, ":5001", ":9"), ":5002", ":5001");
  after = text_with(after, "10.0.0.3:9", "10.0.0.3:5002");
  EXPECT_THAT(sentences_of(changes_to(after)), ElementsAre("! device laser-x: port 5001 -> 5002",
                                                           "! device laser-y: port 5002 -> 5001"));
  // Both moved to ports that nobody had: the same instruments on other ports.
  EXPECT_FALSE(any_asks(
      changes_to(text_with(text_with(kDifferenceCell, ":5001", ":6001"), ":5002", ":6002"))));
}

struct DifferenceCase {
  const char* name;
  std::string from, to, sentence;
  std::vector<std::string> affects;
};
class ConfigurationAsks : public testing::TestWithParam<DifferenceCase> {};
TEST_P(ConfigurationAsks, ChangeAsksAndNamesWhatItAffects) {
  const auto& row = GetParam();
  const auto found = changes_to(text_with(kDifferenceCell, row.from, row.to));
  EXPECT_THAT(sentences_of(found), testing::Contains("! " + row.sentence));
  for (const auto& change : found) {
    if (sentence(change) != row.sentence) continue;
    EXPECT_THAT(change.affects, testing::UnorderedElementsAreArray(row.affects));
  }
}
INSTANTIATE_TEST_SUITE_P(
    Table, ConfigurationAsks,
    testing::Values(
        DifferenceCase{"Part",
                       "part = \"robot\"",
                       "part = \"instrument\"",
                       "probe t07_degC: part robot -> instrument",
                       {"t07"}},
        DifferenceCase{"Place",
                       "beam splitter",
                       "laser head",
                       "probe t08_degC: place beam splitter -> laser head",
                       {"t08"}},
        DifferenceCase{
            "Limit", "max_mm = 4.5", "max_mm = 4", "axis q1_mm: max_mm 4.5 -> 4", {"q1"}},
        DifferenceCase{"Uncertainty",
                       "u_length_nm = 4.6",
                       "u_length_nm = 9",
                       "device laser-x: u_length_nm 4.6 -> 9",
                       {"x", "x_std", "air", "pressure", "humidity", "level"}},
        DifferenceCase{"Instrument",
                       "10.0.0.4:4000",
                       "10.0.0.9:4000",
                       "device tilts: address 10.0.0.4 -> 10.0.0.9",
                       {"ry", "rz", "x", "y"}},
        DifferenceCase{
            "Beam", "12.5", "-12.5", "beam x_mm: offset_mm [0, 12.5, 0] -> [0, -12.5, 0]", {"x"}},
        DifferenceCase{"Sign",
                       "device_axis = 2",
                       "device_axis = 2\n  sign = -1",
                       "angle rz_arcsec: sign 1 -> -1",
                       {"rz", "x", "y"}},
        DifferenceCase{"Geometry",
                       "pose = \"x_mm\"",
                       "pose = \"x_mm\"\nscale_ppm = 12",
                       "kinematics axis q1_mm: scale_ppm 0 -> 12",
                       {"q1", "x", "y"}},
        DifferenceCase{"Load",
                       "[run]",
                       "[load]\nmax_n = 4\n[run]",
                       "load: new: gravity_m_s2 9.80665, max_n 4",
                       {"force"}},
        DifferenceCase{"Plausibility",
                       "[run]",
                       "[plausibility]\nclosure_nm = 500\n[run]",
                       "plausibility: closure_nm 300 -> 500",
                       {}},
        DifferenceCase{"ChannelLimit",
                       "[run]",
                       "[[limit]]\nchannel = \"t07_degC\"\nmax = 30\n[run]",
                       "limit t07_degC: new: max 30",
                       {"t07"}},
        DifferenceCase{"Option",
                       "u_length_nm = 4.6",
                       "u_length_nm = 4.6\noptions = {unit = \"nm\"}",
                       "device laser-x: options.unit not given -> nm",
                       {"x", "x_std", "air", "pressure", "humidity", "level"}}),
    [](const auto& row) { return std::string(row.param.name); });

// Three robots of one axis, and three rules that keep them apart.
std::string three_robots() {
  std::string text = R"(
[cell]
name = "three"
database = "three.db"
listen = "127.0.0.1:0"
)";
  const std::vector<std::string> ids = {"ma", "mn", "mo"};
  for (std::size_t i = 0; i < ids.size(); ++i) {
    std::string one = R"(
[[robot]]
id = "ID"
controller = "c-ID"
[robot.kinematics]
kind = "linear-axis"
[[robot.kinematics.axis]]
motor = "q1_mm"
pose = "x_mm"
offset_mm = 0.NR
[[device]]
id = "c-ID"
kind = "pi-gcs"
address = "10.0.0.NR:50000"
[[device.axis]]
channel = "ID.q1_mm"
device_axis = "X"
min_mm = 0
max_mm = 2
[[device]]
id = "laser-ID"
kind = "interferometer-adapter"
address = "10.0.1.NR:5001"
length = "ID.x_mm"
[[keep_out]]
name = "rule NR"
min_mm = 0.5
at_zero_mm = 9
[[keep_out.axis]]
channel = "ID.q1_mm"
per_mm = -1.0
[[keep_out.axis]]
channel = "OTHER.q1_mm"
per_mm = -1.NR
)";
    const auto put = [&one](const std::string& word, const std::string& by) {
      for (auto at = one.find(word); at != std::string::npos; at = one.find(word, at + by.size()))
        one.replace(at, word.size(), by);
    };
    put("ID", ids[i]);
    put("NR", std::to_string(i + 1));
    put("OTHER", ids[i == 0 ? 1 : 0]);
    text += one;
  }
  return text;
}

TEST(CellFileDifference, ACollisionRuleThatIsChangedAsksWhicheverItIs) {
  const auto before = three_robots();
  EXPECT_THAT(changes_to(before + "# a comment\n", before), IsEmpty());
  for (const std::string number : {"1", "2", "3"})
    EXPECT_THAT(sentences_of(changes_to(
                    text_with(before, "per_mm = -1." + number, "per_mm = -0.25"), before)),
                ElementsAre("! keep_out rule " + number + " axis " + (number == "1" ? "mn" : "ma") +
                            ".q1_mm: per_mm -1." + number + " -> -0.25"));
}

TEST(CellFileDifference, TheGeometryOfARobotThatIsChangedAsksWhicheverItIs) {
  const auto before = three_robots();
  int number = 0;
  for (const std::string id : {"ma", "mn", "mo"}) {
    const std::string offset = "0." + std::to_string(++number);
    const auto found =
        changes_to(text_with(before, "offset_mm = " + offset, "offset_mm = 0.7"), before);
    // That of the first robot stands in the description too.
    ASSERT_THAT(sentences_of(found),
                testing::Contains("! robot " + id + " kinematics axis q1_mm: " + "offset_mm " +
                                  offset + " -> 0.7"));
    EXPECT_THAT(found.back().affects, ElementsAre(id + ".q1"));
  }
}

TEST(CellFileDifference, AProbeThatIsGoneAsks) {
  const auto probe = kDifferenceCell.find("  [[device.probe]]\n  channel = \"t07_degC\"");
  auto after = kDifferenceCell;
  after.erase(probe, kDifferenceCell.find("  [[device.probe]]", probe + 5) - probe);
  const auto found = changes_to(after);
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(found[0].asks);
  EXPECT_THAT(sentence(found[0]), HasSubstr("probe t07_degC: gone: "));
  EXPECT_THAT(found[0].affects, ElementsAre("t07"));
}

TEST(CellFileDifference, ATextThatCannotBeReadAsksForEverything) {
  const auto found = changes_to(kDifferenceCell, "[cell]\nname = \"old\"\nno_longer_known = 1\n");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].asks);
  EXPECT_THAT(found[0].affects, testing::IsSupersetOf({"q1", "t07", "x", "ry"}));
}

}  // namespace
}  // namespace driftwise::formats
