// What the program says of itself: examples that are understood, completions that real shells take,
// pages that groff sets without a warning.

#include <wordexp.h>

#include <filesystem>

#include "clients/cli/commands/manual/completion.h"
#include "clients/cli/commands/manual/examples.h"
#include "clients/cli/commands/manual/man_page.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class ManualTest : public testing::Test {
 protected:
  ManualTest() : program(cli::command_tree(console)) {}

  std::string file(const std::string& name, const std::string& text) {
    const std::string path = folder.path() + "/" + name;
    std::ofstream(path) << text;
    return path;
  }

  std::ostringstream out, err;
  cli::Console console{out, err, false, false, 80, {}, ".", false, 24};
  cli::CommandText program;
  TemporaryFolder folder;
};

// The words that a shell would hand to the program; what comes after a pipe or > is not its own.
std::vector<std::string> words_of(std::string line) {
  for (const char* beyond : {" > ", " >> ", " | "})
    if (const auto at = line.find(beyond); at != std::string::npos) line.resize(at);
  wordexp_t expanded{};
  if (wordexp(line.c_str(), &expanded, WRDE_NOCMD) != 0) return {"a shell cannot read this"};
  std::vector<std::string> words(expanded.we_wordv, expanded.we_wordv + expanded.we_wordc);
  wordfree(&expanded);
  words.erase(words.begin());
  return words;
}

TEST_F(ManualTest, EveryCommandHasAnExample) {
  cli::each_command(program, [](const cli::CommandText& command) {
    if (command.commands.empty()) {
      EXPECT_FALSE(cli::examples_of(command.path).empty())
          << "driftwise " << command.path
          << ": add a line to clients/cli/commands/manual/examples.cc";
    }
  });
}

TEST_F(ManualTest, EveryOptionSaysWhatItIsFor) {
  cli::each_command(program, [](const cli::CommandText& command) {
    for (const auto* options : {&command.options, &command.positionals})
      for (const auto& option : *options)
        EXPECT_FALSE(option.about.empty()) << command.path << " " << option.names.front();
  });
}

TEST_F(ManualTest, EveryExampleIsUnderstood) {
  for (const auto& example : cli::all_examples()) {
    ASSERT_TRUE(example.line.starts_with("driftwise " + std::string(example.verb))) << example.line;
    EXPECT_EQ(cli::misunderstood(words_of(std::string(example.line)), console), std::nullopt)
        << example.line;
  }
}

TEST_F(ManualTest, EveryExampleBelongsToACommand) {
  std::vector<std::string> paths;
  cli::each_command(program, [&](const auto& command) { paths.push_back(command.path); });
  for (const auto& example : cli::all_examples())
    EXPECT_THAT(paths, testing::Contains(std::string(example.verb))) << example.line;
}

TEST_F(ManualTest, BashCompletesCommandsOptionsAndValues) {
  const std::string script = file("driftwise.bash", cli::bash_completion(program));
  const auto completed = [&](const std::string& words, int at) {
    const auto done = run_process(
        {"/bin/bash", "--norc", "-c",
         "source " + script + "; COMP_WORDS=(" + words + "); COMP_CWORD=" + std::to_string(at) +
             "; _driftwise; printf '%s\\n' \"${COMPREPLY[@]}\""},
        std::chrono::seconds(20));
    EXPECT_EQ(done.code, 0) << done.err;
    return done.out;
  };
  EXPECT_EQ(completed("driftwise sta", 1), "status\nstabiliser\nstandard\n");
  EXPECT_EQ(completed("driftwise run st", 2), "start\n");
  EXPECT_EQ(completed("driftwise --json run pa", 3), "pause\n") << "shared options come before";
  EXPECT_EQ(completed("driftwise run start --comp", 3), "--compensate\n");
  EXPECT_EQ(completed("driftwise fit --select ''", 3), "stepwise\nall\n");
  EXPECT_EQ(completed("driftwise run watch --ser", 3), "--server\n");
  EXPECT_EQ(completed("driftwise completion z", 2), "zsh\n");
}

TEST_F(ManualTest, FishCompletesCommandsOptionsAndValues) {
  if (!std::filesystem::exists("/usr/bin/fish")) GTEST_SKIP() << "fish is not installed";
  const std::string script = file("driftwise.fish", cli::fish_completion(program));
  const auto completed = [&](const std::string& line) {
    const auto done = run_process(
        {"/usr/bin/fish", "--no-config", "-c", "source " + script + "; complete -C '" + line + "'"},
        std::chrono::seconds(20), {"HOME=" + folder.path()});
    EXPECT_EQ(done.code, 0) << done.err;
    return done.out;
  };
  EXPECT_THAT(completed("driftwise run st"), testing::StartsWith("start\tStarts a run"));
  EXPECT_THAT(completed("driftwise run start --comp"), testing::StartsWith("--compensate\t"));
  EXPECT_THAT(completed("driftwise fit --select "),
              testing::AllOf(HasSubstr("stepwise"), HasSubstr("all")));
}

TEST_F(ManualTest, ZshReadsItsCompletion) {
  if (!std::filesystem::exists("/usr/bin/zsh")) GTEST_SKIP() << "zsh is not installed";
  const std::string script = file("_driftwise", cli::zsh_completion(program));
  const auto loaded = run_process(
      {"/usr/bin/zsh", "-f", "-c",
       "autoload -U compinit; compinit -D -u; source " + script + "; print ${_comps[driftwise]}"},
      std::chrono::seconds(20));
  EXPECT_EQ(loaded.out, "_driftwise\n") << loaded.err;
  EXPECT_EQ(loaded.err, "");
}

TEST_F(ManualTest, GroffSetsEveryPageWithoutAWarning) {
  if (!std::filesystem::exists("/usr/bin/groff")) GTEST_SKIP() << "groff is not installed";
  const auto pages = cli::man_pages(program, "1.2.3");
  EXPECT_EQ(pages.size(), program.commands.size() + 1);
  for (const auto& [name, text] : pages) {
    const auto set =
        run_process({"/usr/bin/groff", "-man", "-Tutf8", "-P-cbou", "-ww", file(name, text)},
                    std::chrono::seconds(20));
    EXPECT_EQ(set.err, "") << name;
    EXPECT_THAT(set.out, HasSubstr("EXIT STATUS")) << name;
  }
}

TEST_F(ManualTest, AHyphenOnAPageCanBeCopiedToAShell) {
  EXPECT_THAT(cli::man_page(program, "run", "1.2.3"),
              HasSubstr("run start weekend.csv \\-\\-watch"));
  EXPECT_EQ(cli::man_page(program, "dance", "1.2.3"), "");
}

TEST_F(CliTest, HelpOfACommandShowsItsExamples) {
  EXPECT_THAT(run({"run", "start", "--help"}).out,
              testing::AllOf(HasSubstr("Examples:\n  driftwise run start weekend.csv --watch\n"),
                             HasSubstr("Exit codes:")));
}

TEST_F(CliTest, TheManualIsWrittenIntoAFolder) {
  const std::string into = folder.path() + "/man1";
  EXPECT_EQ(run({"man", "--into", into}).exit, 0);
  EXPECT_TRUE(std::filesystem::exists(into + "/driftwise-run.1"));
  EXPECT_EQ(run({"man", "dance"}).exit, 3);
  EXPECT_EQ(run({"completion", "powershell"}).exit, 2);
}

}  // namespace
}  // namespace driftwise::tests
