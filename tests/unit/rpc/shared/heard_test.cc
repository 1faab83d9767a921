// Commands that move something and were asked for long ago.

#include "server/rpc/shared/heard.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>

#include <set>

#include "driftwise/v1/access.pb.h"
#include "driftwise/v1/cell_service.pb.h"
#include "driftwise/v1/commissioning_service.pb.h"
#include "driftwise/v1/diagnosis_service.pb.h"
#include "driftwise/v1/queue_service.pb.h"
#include "driftwise/v1/run_service.pb.h"

namespace driftwise::tests {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr const char* kResume = "/driftwise.v1.RunService/ResumeRun";
constexpr const char* kJog = "/driftwise.v1.CommissioningService/BeginJog";
constexpr const char* kStop = "/driftwise.v1.CellService/StopAll";

Result<void> judged(std::string_view path, milliseconds age) {
  const std::chrono::system_clock::time_point now{std::chrono::hours(500'000)};
  const auto heard = std::chrono::duration_cast<milliseconds>((now - age).time_since_epoch());
  return rpc::heard_recently(path, std::to_string(heard.count()), now);
}

TEST(Heard, ARunIsResumedByWhoHasSeenTheCellWithinFiveSeconds) {
  EXPECT_TRUE(judged(kResume, milliseconds(5000)));
  const auto late = judged(kResume, milliseconds(66'000));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().reason, "ASKED_LONG_AGO");
  EXPECT_EQ(late.error().code, ErrorCode::failed_precondition);
  EXPECT_THAT(late.error().message, HasSubstr("66.0 s old"));
}

TEST(Heard, AJogHasTheTimeOfAHeartbeat) {
  EXPECT_TRUE(judged(kJog, milliseconds(1200)));
  EXPECT_FALSE(judged(kJog, milliseconds(1600)));
}

TEST(Heard, AStopIsNeverTooLate) { EXPECT_TRUE(judged(kStop, milliseconds(600'000))); }

TEST(Heard, AClockThatWasSetBackRefusesNothing) {
  EXPECT_TRUE(judged(kResume, milliseconds(-3'600'000)));
}

TEST(Heard, ATimeThatIsNoneIsRefusedWithWhatIsExpected) {
  const auto bad = rpc::heard_recently(kResume, "soon", std::chrono::system_clock::now());
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error().message, HasSubstr("'soon', expected Unix time in ms"));
}

// Whatever takes the lease or starts a run moves; the list is docs/gui.md's.
TEST(Heard, EveryRpcThatMovesHasALimit) {
  std::set<std::string> limited;
  for (const auto* any : {v1::HomeRequest::descriptor(), v1::BeginJogRequest::descriptor(),
                          v1::ReleaseQueueRequest::descriptor(), v1::ResumeRunRequest::descriptor(),
                          v1::CreateImprovementRequest::descriptor()})
    for (int i = 0; i < any->file()->service_count(); ++i)
      for (int k = 0; k < any->file()->service(i)->method_count(); ++k)
        if (const auto* method = any->file()->service(i)->method(k);
            method->options().GetExtension(v1::heard_within_ms) > 0)
          limited.insert(method->name());
  EXPECT_THAT(limited, testing::UnorderedElementsAre(
                           "Home", "Move", "SetStabiliser", "TuneStabiliser", "BeginJog",
                           "AddQueueEntry", "ChangeQueueEntry", "MoveQueueEntry", "ReleaseQueue",
                           "CreateRun", "ResumeRun", "ConfirmForce", "CreateImprovement"));
}

}  // namespace
}  // namespace driftwise::tests
