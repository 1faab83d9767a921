// The [y/N] question and a person who interrupts it.

#include "clients/cli/core/confirm.h"

#include <gtest/gtest.h>

#include <sstream>

namespace driftwise::cli {
namespace {

class Confirm : public testing::Test {
 protected:
  ExitCode exit_of_asking(bool interrupts) {
    std::istringstream in("y\n");
    Console console{out, err,   true, true, 80,   {},
                    ".", false, 24,   &in,  true, [interrupts] {
                      return !interrupts; }};
    try {
      confirm(console, false, "model 1 serves no longer", {}, "Roll back");
    } catch (const Failure& failure) {
      return failure.exit;
    }
    return ExitCode::done;
  }
  std::ostringstream out, err;
};

TEST_F(Confirm, TakesAnAnswerThatWasTyped) { EXPECT_EQ(exit_of_asking(false), ExitCode::done); }

TEST_F(Confirm, EndsAtTheFirstInterruptAndReadsNoAnswer) {
  EXPECT_EQ(exit_of_asking(true), ExitCode::interrupted);
}

}  // namespace
}  // namespace driftwise::cli
