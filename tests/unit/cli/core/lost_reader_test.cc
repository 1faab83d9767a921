// Commands that follow, where what they write arrives nowhere any more: `driftwise readings | head
// -1`, a full disk.

#include <streambuf>

#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

// Takes whole writes until so many bytes are in, then none.
class FullDisk final : public std::streambuf {
 public:
  explicit FullDisk(std::size_t room) : room_(room) {}
  std::string taken;

 protected:
  int overflow(int c) override {
    const char one = static_cast<char>(c);
    return xsputn(&one, 1) == 1 ? c : traits_type::eof();
  }
  std::streamsize xsputn(const char* text, std::streamsize count) override {
    if (taken.size() >= room_) return 0;
    taken.append(text, static_cast<std::size_t>(count));
    return count;
  }

 private:
  std::size_t room_;
};

class WhoeverFollows : public CliTest, public testing::WithParamInterface<const char*> {
 protected:
  // --timeout ends a command that does not look, with another exit code.
  int exit_of(std::vector<std::string> arguments, FullDisk& disk) {
    std::ostream out(&disk);
    std::ostringstream err;
    cli::Console console{out, err, false, false, 80, environment, folder.path()};
    arguments.insert(arguments.end(), {"--timeout", "20"});
    return cli::run_cli(std::move(arguments), console);
  }
};

TEST_P(WhoeverFollows, EndsWhenNobodyTakesWhatItWrites) {
  std::istringstream words(GetParam());
  std::vector<std::string> arguments;
  for (std::string word; words >> word;) arguments.push_back(word);
  const auto passing = cell.passing();
  FullDisk disk(1);
  EXPECT_EQ(exit_of(arguments, disk), 0) << "main.cc says what is wrong with the output";
  EXPECT_NE(disk.taken, "");
}

INSTANTIATE_TEST_SUITE_P(Commands, WhoeverFollows,
                         testing::Values("readings", "readings --json", "watch", "watch --json",
                                         "watch --every 0", "align --every 0.1",
                                         "align --every 0.1 --json", "events --follow"),
                         [](const auto& row) { return "Of" + std::to_string(row.index); });

}  // namespace
}  // namespace driftwise::tests
