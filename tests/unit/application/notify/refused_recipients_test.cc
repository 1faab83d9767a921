// Recipients of a mail, each by itself.

#include "server/application/notify/refused_recipients.h"

#include <gmock/gmock.h>

namespace driftwise::application {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

constexpr const char* kAdasMail = "ada@lab.example";
constexpr const char* kBobsMail = "bob@lab.example";

CellTime after_s(double s) { return CellTime{1'795'248'000'000'000'000} + nanoseconds_from_s(s); }

Notice notice_of(std::int64_t alarm) {
  Notice notice;
  notice.news.emplace_back().alarm.id = {alarm};
  return notice;
}

tl::unexpected<Error> refusal(ErrorCode code) { return fail(code, "NOT_DELIVERED", "no"); }

class RefusedRecipientsTest : public testing::Test {
 protected:
  void mail(double s, std::int64_t alarm, std::vector<Delivery::Refused> refused) {
    recipients.take(notice_of(alarm), {kAdasMail, kBobsMail}, refused, after_s(s));
  }
  RefusedRecipients recipients;
};

TEST_F(RefusedRecipientsTest, OneWhoIsRefusedForNowGetsTheSameMailAgain) {
  mail(0, 7, {{kBobsMail, "450 4.2.0 greylisted", true}});
  EXPECT_TRUE(recipients.has_reached(kAdasMail));
  EXPECT_FALSE(recipients.has_reached(kBobsMail));
  double s = 0;
  for (const double wait_s : {1.0, 2.0, 4.0}) {
    EXPECT_FALSE(recipients.due(after_s(s + wait_s - 0.1)));
    s += wait_s;
    const auto due = recipients.due(after_s(s));
    ASSERT_TRUE(due) << s;
    EXPECT_EQ(due->address, kBobsMail);
    EXPECT_EQ(due->notice.news[0].alarm.id.value, 7);
    recipients.tried_again(kBobsMail, refusal(ErrorCode::unavailable), after_s(s), 0);
  }
  EXPECT_THAT(recipients.failing(after_s(59), 60), IsEmpty());
  EXPECT_THAT(recipients.failing(after_s(60), 60), SizeIs(1));
  recipients.tried_again(kBobsMail, Delivery("250 OK"), after_s(61), 0);
  EXPECT_THAT(recipients.failing(after_s(61), 60), IsEmpty());
  EXPECT_FALSE(recipients.due(after_s(1e6)));
  EXPECT_TRUE(recipients.has_reached(kBobsMail));
}

TEST_F(RefusedRecipientsTest, OneWhoIsRefusedForGoodIsSaidAtOnceAndNotTriedAgain) {
  mail(0, 7, {{kBobsMail, "550 5.1.1 no such user", false}});
  ASSERT_THAT(recipients.failing(after_s(0), 60), SizeIs(1));
  EXPECT_EQ(recipients.failing(after_s(0), 60)[0].why, "550 5.1.1 no such user");
  EXPECT_FALSE(recipients.due(after_s(1e6)));
  mail(100, 8, {});
  EXPECT_THAT(recipients.failing(after_s(100), 60), IsEmpty()) << "the mailbox is there again";
}

TEST_F(RefusedRecipientsTest, AServerThatRefusesForGoodLaterEndsTheTries) {
  mail(0, 7, {{kBobsMail, "450 4.2.0 greylisted", true}});
  recipients.tried_again(kBobsMail, refusal(ErrorCode::failed_precondition), after_s(1), 0);
  EXPECT_FALSE(recipients.due(after_s(1e6)));
  EXPECT_THAT(recipients.failing(after_s(1), 60), SizeIs(1));
}

TEST_F(RefusedRecipientsTest, WhatWaitsGoesInItsOrderOnceTheWayIsOpen) {
  mail(0, 7, {{kBobsMail, "450", true}});
  mail(0.5, 8, {{kBobsMail, "450", true}});
  mail(0.7, 9, {});  // taken for both
  ASSERT_TRUE(recipients.due(after_s(0.7)));
  EXPECT_EQ(recipients.due(after_s(0.7))->notice.news[0].alarm.id.value, 7);
  recipients.tried_again(kBobsMail, Delivery("250 OK"), after_s(0.7), 0);
  ASSERT_TRUE(recipients.due(after_s(0.7)));
  EXPECT_EQ(recipients.due(after_s(0.7))->notice.news[0].alarm.id.value, 8);
}

TEST_F(RefusedRecipientsTest, ABoundedNumberOfMailsWaits) {
  for (std::int64_t alarm = 1; alarm <= 100; ++alarm) mail(0, alarm, {{kBobsMail, "450", true}});
  ASSERT_TRUE(recipients.due(after_s(1)));
  EXPECT_EQ(recipients.due(after_s(1))->notice.news[0].alarm.id.value,
            101 - static_cast<std::int64_t>(RefusedRecipients::kMostWaiting));
}

}  // namespace
}  // namespace driftwise::application
