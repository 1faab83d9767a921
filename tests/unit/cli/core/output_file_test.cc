// What -o does to what stood there before.

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>

#include "clients/cli/core/session.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

namespace fs = std::filesystem;

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// What it says when it cannot; "" when it can.
std::string complaint_of(const std::string& path) {
  try {
    cli::write_output_file(path, "new");
  } catch (const cli::Failure& failure) {
    EXPECT_EQ(failure.exit, cli::ExitCode::bad_input);
    EXPECT_EQ(failure.reason, "CANNOT_WRITE");
    return failure.message;
  }
  return {};
}

TEST(OutputFile, TakesThePlaceOfAFile) {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/a.csv";
  std::ofstream(path) << "old and longer";
  cli::write_output_file(path, "new");
  EXPECT_EQ(text_of(path), "new");
  EXPECT_FALSE(fs::exists(path + ".part"));
}

// "data import raw.csv --mapping map.toml -o raw.csv" would leave no raw data.
TEST(OutputFile, DoesNotTakeThePlaceOfAFileThatWasRead) {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/raw.csv";
  std::ofstream(path) << "measured";
  fs::create_symlink(path, folder.path() + "/link.csv");
  for (const char* name : {"/raw.csv", "/link.csv"})
    EXPECT_THROW(cli::write_output_file(folder.path() + name, "new", {path}), cli::Failure);
  EXPECT_EQ(text_of(path), "measured");
  cli::write_output_file(folder.path() + "/other.csv", "new", {path, ""});
  EXPECT_EQ(text_of(folder.path() + "/other.csv"), "new");
}

// `-o /dev/stdout >> file` and `-o -`: behind what stands in the file already.
TEST(OutputFile, AddsToWhatStandardOutputIsRedirectedTo) {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/results.csv";
  std::ofstream(path) << "of yesterday\n";
  std::cout << std::flush;
  const int kept = ::dup(STDOUT_FILENO);
  const int redirected = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  ::dup2(redirected, STDOUT_FILENO);
  std::cout << "head\n";
  std::string complaints;
  for (const char* name : {"/dev/stdout", "-", "/proc/self/fd/1"}) complaints += complaint_of(name);
  std::cout << "\ntail\n" << std::flush;
  ::dup2(kept, STDOUT_FILENO);
  ::close(kept);
  EXPECT_EQ(complaints, "");
  EXPECT_EQ(complaint_of("/dev/fd/" + std::to_string(redirected)), "");
  ::close(redirected);
  EXPECT_EQ(text_of(path), "of yesterday\nhead\nnewnewnew\ntail\nnew");
  EXPECT_FALSE(fs::exists("-")) << "a file of that name";
}

// A file renamed over /dev/null would be the end of /dev/null.
TEST(OutputFile, IsWrittenIntoAPipeOrDeviceAndDoesNotReplaceIt) {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/pipe";
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  cli::write_output_file(path, "new");
  char got[8] = {};
  EXPECT_EQ(::read(reader, got, sizeof got), 3);
  EXPECT_STREQ(got, "new");
  ::close(reader);
  EXPECT_TRUE(fs::is_fifo(path));
}

TEST(OutputFile, FollowsALink) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() + "/real.csv") << "old";
  fs::create_symlink("real.csv", folder.path() + "/link.csv");
  cli::write_output_file(folder.path() + "/link.csv", "new");
  EXPECT_TRUE(fs::is_symlink(folder.path() + "/link.csv"));
  EXPECT_EQ(text_of(folder.path() + "/real.csv"), "new");
}

TEST(OutputFile, FollowsALinkToAFileThatIsNotThereYet) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() + "/disk");
  fs::create_symlink("disk/real.csv", folder.path() + "/second.csv");
  fs::create_symlink("second.csv", folder.path() + "/link.csv");
  cli::write_output_file(folder.path() + "/link.csv", "new");
  EXPECT_TRUE(fs::is_symlink(folder.path() + "/link.csv"));
  EXPECT_EQ(text_of(folder.path() + "/disk/real.csv"), "new");
  fs::create_symlink("none/real.csv", folder.path() + "/lost.csv");
  EXPECT_THAT(complaint_of(folder.path() + "/lost.csv"), HasSubstr("No such file or directory"));
  EXPECT_TRUE(fs::is_symlink(folder.path() + "/lost.csv"));
}

TEST(OutputFile, SaysWhyNotAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  EXPECT_THAT(complaint_of(folder.path() + "/none/a.csv"),
              testing::EndsWith("none/a.csv: No such file or directory"));
  EXPECT_THAT(complaint_of(folder.path()), HasSubstr("it is a folder"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 0);
  EXPECT_FALSE(fs::exists(folder.path() + ".part"));
  // A device that is always full, behind a link so that nothing could replace it.
  fs::create_symlink("/dev/full", folder.path() + "/full");
  EXPECT_THAT(complaint_of(folder.path() + "/full"), HasSubstr("No space left on device"));
}

using OutputOfACommand = CliTest;

// Ten rows of a line, and a plate of what is written about the fit.
std::string line_of_data() {
  std::string csv = "x_mm,q1_mm\n";
  for (int i = 0; i < 10; ++i)
    csv += std::to_string(i) + "," + std::to_string(2 * i) + "." + std::to_string(i % 3) + "\n";
  return csv;
}

TEST_F(OutputOfACommand, HasStandardOutputAlone) {
  const std::string data = file("data.csv", line_of_data());
  const std::vector<std::string> fit = {"fit", data, "--model", "q1 ~ x"};
  for (const char* name : {"-", "/dev/stdout"}) {
    auto arguments = fit;
    arguments.insert(arguments.end(), {"-o", name});
    const auto outcome = run(arguments);
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    EXPECT_TRUE(nlohmann::json::accept(outcome.out)) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr("q1 is limited by"));
    const auto grid =
        run({"trajectory", "grid", "--axes", "q1", "--block", "calibration 0:1:0.5", "-o", name});
    EXPECT_EQ(grid.exit, 0) << grid.err;
    EXPECT_THAT(grid.out, testing::Not(HasSubstr("points in"))) << name;
    EXPECT_THAT(grid.out, HasSubstr("q1_mm,"));
  }
}

TEST_F(OutputOfACommand, IsRefusedWhereAnotherIsStandardOutputToo) {
  const std::string data = file("data.csv", line_of_data());
  const auto outcome =
      run({"fit", data, "--model", "q1 ~ x", "-o", "-", "--residuals", "/dev/stdout"});
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("--output and --residuals are both"),
                                          HasSubstr("give one of them the name of a file")));
}

// Rows that calibrate: none at all is not every one.
TEST_F(OutputOfACommand, OfAFitToNoRowsIsRefused) {
  const auto outcome =
      run({"fit", file("data.csv", line_of_data()), "--model", "q1 ~ x", "--first", "0"});
  EXPECT_EQ(outcome.exit, 2);
  EXPECT_THAT(outcome.err, HasSubstr("found '0', expected a number above 0"));
}

// A certificate that is not there ends the watchdog before it waits, behind the line it understood.
TEST_F(OutputOfACommand, OfTheWatchdogTakesTheRestOfTheLineForItsProgram) {
  const auto outcome =
      run({"watchdog", "--listen", "127.0.0.1:0", "--certificate", folder.path() + "/none.pem",
           "--key", folder.path() + "/none.pem", "--command", "logger", "-p", "user.alert", "-t",
           "cell", "--listen", "{title}"});
  EXPECT_EQ(outcome.exit, 3);
  EXPECT_THAT(outcome.err, HasSubstr("none.pem"));
}

}  // namespace
}  // namespace driftwise::tests
