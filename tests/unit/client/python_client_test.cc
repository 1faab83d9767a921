// clients/python/driftwise.py where nothing answers, and what it makes of messages.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/support/process.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

class PythonClient : public testing::Test {
 protected:
  void SetUp() override {
    if (run_process({"/usr/bin/python3", "-c", "import grpc, google.protobuf"}).code != 0)
      GTEST_SKIP() << "python3-grpcio is not installed (apt install python3-grpcio)";
  }
  // What the script prints; argv[1]: an address where nobody listens, argv[2]: a folder.
  std::string said(const std::string& script) const {
    const auto done =
        run_process({"/usr/bin/python3", "-c",
                     "import sys, time\nsys.path.insert(0, '" + std::string(DRIFTWISE_SOURCE_DIR) +
                         "/clients/python')\nimport driftwise\n" + script,
                     "127.0.0.1:1", folder.path()},
                    std::chrono::minutes(1), {"PYTHONDONTWRITEBYTECODE=1"});
    EXPECT_EQ(done.code, 0) << done.err;
    return done.out + done.err;
  }
  // Says the reason of latest() as soon as it is another one than NOT_YET.
  static std::string follow(const std::string& credentials) {
    return "follower = driftwise.Cell(sys.argv[1], " + credentials +
           ").follow(x_mm=1)\n"
           "while True:\n"
           "    follower.wait(0, 20)\n"
           "    try: follower.latest()\n"
           "    except driftwise.DriftwiseError as error: print(error.reason)\n"
           "    break\n";
  }
  const TemporaryFolder folder;
};

TEST_F(PythonClient, TakesATokenAsItsFileHoldsIt) {
  EXPECT_EQ(said(follow("token='dwt_secret\\n'")), "NO_DAEMON\n");
}

TEST_F(PythonClient, RefusesATokenThatNoHeaderHolds) {
  EXPECT_THAT(said("try: driftwise.Cell(sys.argv[1], token='dwt one')\n"
                   "except ValueError as error: print(error)\n"),
              testing::AllOf(HasSubstr("expected one word"), testing::Not(HasSubstr("dwt"))));
}

TEST_F(PythonClient, TellsAFollowersCallerWhatItsThreadMet) {
  std::ofstream(folder.path() + "/two.token") << "dwt_one\ndwt_two\n";
  EXPECT_EQ(said(follow("token_file=sys.argv[2] + '/two.token'")), "BAD_CREDENTIALS\n");
  EXPECT_EQ(said(follow("token_file=sys.argv[2] + '/none.token'")), "NO_TOKEN\n");
  EXPECT_EQ(said("driftwise.Cell._watch = lambda *_: 1 / 0\n" + follow("token='dwt_secret'")),
            "CLIENT_FAILED\n");
}

TEST_F(PythonClient, SaysThatNothingWasStoppedWhateverTheReason) {
  const std::string stop =
      "try: cell.stop_all(20)\n"
      "except driftwise.DriftwiseError as error: print(error.reason, str(error)[:11])\n";
  EXPECT_EQ(said("cell = driftwise.Cell(sys.argv[1])\n" + stop), "NO_DAEMON NOT STOPPED\n");
  EXPECT_EQ(
      said("cell = driftwise.Cell(sys.argv[1], token_file=sys.argv[2] + '/none.token')\n" + stop),
      "NO_TOKEN NOT STOPPED\n");
}

// As the C++ library and the text line have them.
TEST_F(PythonClient, WritesFlagsAsTheTextLineDoes) {
  EXPECT_EQ(said("print(*driftwise._target_from(driftwise._CLASS['Target'](flags=[6, 7, 1, 99],\n"
                 "    unreachable_channels=['q3_mm'], unlimited_channels=['mn.q1_mm', 'q2_mm'],\n"
                 "    outside_channels=['x_mm'])).flags)\n"),
            "OUTSIDE_LIMITS(q3) UNKNOWN_LIMITS(mn.q1+q2) OUTSIDE_DOMAIN(x_mm) UNKNOWN_FLAG(99)\n");
}

// A call that ends without the daemon's own reason was ended by the daemon's end.
TEST_F(PythonClient, TakesACodeWithoutAReasonForALostDaemon) {
  EXPECT_EQ(said("class Failed:\n"
                 "    code = lambda self: driftwise.grpc.StatusCode.CANCELLED\n"
                 "    details = lambda self: 'CANCELLED'\n"
                 "    trailing_metadata = lambda self: ()\n"
                 "print(driftwise._error_of(Failed(), 'here').reason)\n"),
            "NO_DAEMON\n");
}

// The next answer is held back for an hour; the target lives for 50 ms.
TEST_F(PythonClient, KeepsNoTargetBeyondItsLifeForTheSakeOfAnInterval) {
  EXPECT_EQ(said("asked = []\n"
                 "class Stream:\n"
                 "    def __init__(self):\n"
                 "        now = driftwise.datetime.datetime.now(driftwise.datetime.timezone.utc)\n"
                 "        target = driftwise._CLASS['Target'](model_id=7)\n"
                 "        target.conditions_time.FromDatetime(now)\n"
                 "        target.valid_until_time.FromDatetime(\n"
                 "            now + driftwise.datetime.timedelta(milliseconds=50))\n"
                 "        self.answers = iter([driftwise._CLASS['WatchTargetsResponse'](\n"
                 "            target=target)])\n"
                 "        self.ended = driftwise.threading.Event()\n"
                 "    def __iter__(self):\n"
                 "        yield from self.answers\n"
                 "        self.ended.wait(60)\n"
                 "    def cancel(self): self.ended.set()\n"
                 "def watch(self, pose, interval_s):\n"
                 "    asked.append(interval_s)\n"
                 "    return Stream()\n"
                 "driftwise.Cell._watch = watch\n"
                 "follower = driftwise.Cell(sys.argv[1]).follow(x_mm=1, min_interval_s=3600)\n"
                 "reason = ''\n"
                 "until = time.monotonic() + 20\n"
                 "while reason in ('', 'NOT_YET') and time.monotonic() < until:\n"
                 "    try: follower.latest(); time.sleep(0.01)\n"
                 "    except driftwise.DriftwiseError as error: reason = error.reason\n"
                 "print(reason, *asked)\n"),
            "EXPIRED 3600 0.025\n");
}

}  // namespace
}  // namespace driftwise::tests
