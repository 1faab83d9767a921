// driftwise configuration: the difference is shown, and nothing is accepted unseen.

#include "clients/cli/pages/configuration_text.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class ConfigurationCommands : public CliTest {
 protected:
  ConfigurationCommands() {
    fakes.configurations = &configurations;
    cell.on_store([this](Store& store) {
      ConfigurationStart start;
      start.hash = "bbbb";
      start.before_hash = "aaaa";
      start.asks = true;
      start.version = "0.1.0";
      start.at.utc = {1'790'000'000'000'000'000};
      start.changes_json = formats::write_changes_json(
          {{"probe t07_degC", "input", "107", "108", true, {"t07"}},
           {"cell", "listen", "127.0.0.1:1", "127.0.0.1:2", false, {}}});
      configurations.start = store.configurations().begin(start, kText)->id;
      configurations.view.hash = "bbbb";
      configurations.view.text = kText;
    });
  }
  static constexpr const char* kText = "[cell]\nname = \"bench\"\n";
  FakeConfigurations configurations{cell};
};

TEST_F(ConfigurationCommands, ShowSaysWhatAsksAndWhatIsRecordedOnly) {
  const auto said = run({"configuration", "show"});
  EXPECT_EQ(said.exit, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("configuration bbbb\nsince aaaa:\n"));
  EXPECT_THAT(said.out, HasSubstr("asks      probe t07_degC: input 107 -> 108"));
  EXPECT_THAT(said.out, HasSubstr("recorded  cell: listen 127.0.0.1:1 -> 127.0.0.1:2"));
  EXPECT_THAT(said.out, HasSubstr("driftwise configuration accept"));
  EXPECT_EQ(run({"configuration", "show", "--text"}).out, "[cell]\nname = \"bench\"\n");
  EXPECT_THAT(run({"configuration", "list"}).out, HasSubstr("open"));
  EXPECT_EQ(json({"configuration", "show"})["start"]["changes"][0]["asks"], true);
}

TEST_F(ConfigurationCommands, AnAnswerThatIsTooLargeIsNotTakenForTheRequest) {
  cell.on_executor([this] {
    configurations.view.text.assign((64 << 20) + 1, 'x');
    return true;
  });
  const auto said = run({"configuration", "show", "--text"});
  EXPECT_EQ(said.exit, 5);
  EXPECT_THAT(said.err, HasSubstr("the answer is larger than 64 MiB"));
  EXPECT_THAT(said.err, testing::Not(HasSubstr("nothing was stored")));
}

TEST_F(ConfigurationCommands, AcceptShowsTheDifferenceAndAsks) {
  EXPECT_EQ(run({"configuration", "accept"}).exit, 2);
  const auto declined = run({"configuration", "accept"}, true, "n\n");
  EXPECT_EQ(declined.exit, 5);
  EXPECT_THAT(declined.err, HasSubstr("probe t07_degC: input 107 -> 108"));
  EXPECT_THAT(declined.err, testing::Not(HasSubstr("listen")));
  EXPECT_EQ(run({"configuration", "accept", "--note", "new plugs"}, true, "y\n").exit, 0);
  EXPECT_EQ(cell.on_executor([this] { return configurations.last_note; }), "new plugs");
  const auto again = run({"configuration", "accept", "--yes"});
  EXPECT_EQ(again.exit, 5);
  EXPECT_THAT(again.err, HasSubstr("nothing to accept"));
  EXPECT_THAT(run({"configuration", "list"}).out, HasSubstr("by ada"));
}

}  // namespace
}  // namespace driftwise::tests
