// The watchdog as a whole: signs of life by libcurl, messages to a receiver of the test's own.

#include "server/watchdog/watchdog.h"

#include <gmock/gmock.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <future>
#include <mutex>
#include <thread>

#include "server/notify/notice_text.h"
#include "server/notify/outside_notifier.h"
#include "server/watchdog/watchdog_door.h"
#include "tests/support/process.h"

namespace driftwise::watchdog {
namespace {

using testing::HasSubstr;

// Takes messages, once `refusals` of them were refused.
class Taking final : public Notifier {
 public:
  Result<Delivery> tell(const ReceiverDescription& receiver, const Notice& notice) override {
    const std::lock_guard lock(mutex_);
    if (refusals_ > 0) {
      --refusals_;
      return fail(ErrorCode::unavailable, "NOT_DELIVERED", "not yet");
    }
    if (std::exchange(greylists_, false)) {
      Delivery delivery("taken");
      delivery.refused = {{receiver.to.back(), "450 4.2.0 greylisted", true}};
      mails_.push_back({receiver.to.front()});
      for (const auto& news : notice.news) taken_.push_back(news);
      return delivery;
    }
    mails_.push_back(receiver.to);
    for (const auto& news : notice.news) taken_.push_back(news);
    notices_.push_back(notice);
    return std::string("taken");
  }
  Result<std::string> report(const WatchdogRules&, const LifeSign&) override {
    return std::string();
  }
  void shut_down() override {}
  std::vector<AlarmNews> taken() const {
    const std::lock_guard lock(mutex_);
    return taken_;
  }
  void refuse(int times) { refusals_ = times; }
  void greylist_once() { greylists_ = true; }
  std::vector<std::vector<std::string>> mails() const {  // their recipients
    const std::lock_guard lock(mutex_);
    return mails_;
  }
  std::vector<Notice> notices() const {
    const std::lock_guard lock(mutex_);
    return notices_;
  }

 private:
  mutable std::mutex mutex_;
  int refusals_ = 0;
  bool greylists_ = false;
  std::vector<AlarmNews> taken_;
  std::vector<std::vector<std::string>> mails_;
  std::vector<Notice> notices_;
};

class WatchdogTest : public testing::Test {
 protected:
  ~WatchdogTest() override { end(); }
  void begin(double silent_after_s, std::vector<std::string> cells = {},
             std::unique_ptr<tls::TlsMaterial> tls = nullptr) {
    over_ = false;
    std::promise<std::string> ready;
    thread_ = std::thread([this, silent_after_s, cells, &ready, &tls] {
      WatchdogOptions options;
      options.tls = std::move(tls);
      options.listen = "127.0.0.1:0";
      options.token = "s3cret";
      options.heads = heads;
      options.expect = cells;
      options.silent_after_s = silent_after_s;
      options.receiver.to = to;
      const auto done = run_watchdog(
          std::move(options), taking, [&ready](const std::string& a) { ready.set_value(a); },
          [](const std::string&) {}, [this] { return over_.load(); });
      EXPECT_TRUE(done) << done.error().message;
    });
    address = ready.get_future().get();
  }
  void end() {
    over_ = true;
    if (thread_.joinable()) thread_.join();
  }
  Result<std::string> say(const LifeSign& sign, const std::string& token = "s3cret",
                          const std::string& authority = {}) {
    const std::string file = folder.path() + "/token";
    const auto made = tests::run_process(
        {"/bin/sh", "-c", "umask 077; printf '%s\\n' \"$1\" > \"$2\"", "sh", token, file});
    EXPECT_EQ(made.code, 0);
    // The certificate of these tests is for localhost.
    const std::string url = authority.empty()
                                ? "http://" + address + "/"
                                : "https://localhost" + address.substr(address.rfind(':')) + "/";
    return outside_.report({url, 30, file, authority}, sign);
  }
  std::vector<AlarmNews> wait_for(std::size_t count) {
    for (int i = 0; i < 6000 && taking.taken().size() < count; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return taking.taken();
  }
  static LifeSign sign(std::int64_t entry, char digit) {
    LifeSign sign;
    sign.cell = "cell-a";
    sign.at = {1'795'248'000'000'000'000};
    sign.head = {entry, std::string(64, digit)};
    return sign;
  }

  tests::TemporaryFolder folder;
  std::string heads = folder.path() + "/heads.log", address;
  Taking taking;
  std::vector<std::string> to;

 private:
  notify::OutsideNotifier outside_;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

TEST_F(WatchdogTest, KeepsTheHeadBeforeItAnswers) {
  begin(1000);
  const auto said = say(sign(4, 'a'));
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(*said, "HTTP 204");
  EXPECT_THAT(tests::read_file(heads), HasSubstr(std::string(64, 'a') + "@4 cell-a\n"));
}

TEST_F(WatchdogTest, TakesNothingWithoutTheToken) {
  begin(1000);
  const auto said = say(sign(4, 'a'), "guess");
  ASSERT_FALSE(said);
  EXPECT_THAT(said.error().message, HasSubstr("HTTP 401"));
  EXPECT_EQ(tests::read_file(heads), "");
}

TEST_F(WatchdogTest, TakesASignOfLifeBesideConnectionsThatSayNothing) {
  begin(1000);
  boost::asio::io_context context;
  std::vector<boost::asio::ip::tcp::socket> silent;
  const boost::asio::ip::tcp::endpoint door(
      boost::asio::ip::make_address("127.0.0.1"),
      static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  for (std::size_t i = 0; i < 2 * WatchdogDoor::kMaxConnections; ++i) {
    silent.emplace_back(context);
    silent.back().connect(door);
  }
  const auto said = say(sign(4, 'a'));
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(*said, "HTTP 204");
}

TEST_F(WatchdogTest, SpeaksTlsWithACertificateThatIsVerified) {
  const std::string key = folder.path() + "/key.pem", certificate = folder.path() + "/cert.pem";
  const auto made =
      tests::run_process({"/usr/bin/openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes",
                          "-days", "2", "-subj", "/CN=localhost", "-addext",
                          "subjectAltName=DNS:localhost", "-keyout", key, "-out", certificate});
  ASSERT_EQ(made.code, 0) << made.err;
  auto tls =
      tls::TlsMaterial::open({certificate, key, ""}, tls::ClientCertificate::ignored, "http/1.1");
  ASSERT_TRUE(tls) << tls.error().message;
  begin(1000, {}, std::move(*tls));
  const auto said = say(sign(4, 'a'), "s3cret", certificate);
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(*said, "HTTP 204");
  EXPECT_FALSE(say(sign(5, 'b')));  // without TLS
  // An authority that nobody named has not signed it.
  EXPECT_FALSE(say(sign(5, 'b'), "s3cret", "/etc/ssl/certs/ca-certificates.crt"));
  EXPECT_THAT(tests::read_file(heads), testing::Not(HasSubstr("@5")));
}

TEST_F(WatchdogTest, RaisesSilenceUntilItIsDeliveredAndTellsItsEnd) {
  taking.refuse(1);
  begin(1);
  ASSERT_TRUE(say(sign(4, 'a')));
  const auto silent = wait_for(1);
  ASSERT_EQ(silent.size(), 1U);
  EXPECT_EQ(silent[0].alarm.kind, "cell.silent");
  ASSERT_TRUE(say(sign(5, 'b')));
  const auto back = wait_for(2);
  ASSERT_GE(back.size(), 2U);
  EXPECT_EQ(back[1].kind, NewsKind::resolved);
}

// The daemon is silent, and its alarm 1 is another one.
TEST_F(WatchdogTest, SaysWhatToDoAtTheCellAndNamesNoCommandOfItsDaemon) {
  begin(1, {"cell-a"});
  ASSERT_EQ(wait_for(1).size(), 1U);
  const auto notice = taking.notices().front();
  const auto text = notify::text_of(notice);
  EXPECT_THAT(text, testing::Not(HasSubstr("driftwise alarms")));
  EXPECT_THAT(text, testing::Not(HasSubstr("alarm 1")));
  EXPECT_THAT(text, HasSubstr("go and look at the cell: its computer, its daemon"));
  EXPECT_THAT(text, HasSubstr("told again every 4 h until it speaks"));
}

TEST_F(WatchdogTest, TriesARecipientAgainWhoIsRefusedForNow) {
  to = {"ada@lab.example", "bob@lab.example"};
  taking.greylist_once();
  begin(1, {"cell-a"});
  ASSERT_EQ(wait_for(2).size(), 2U);
  EXPECT_THAT(taking.mails(), testing::ElementsAre(std::vector<std::string>{"ada@lab.example"},
                                                   std::vector<std::string>{"bob@lab.example"}));
}

TEST_F(WatchdogTest, ExpectsWhatItKnewBeforeItsRestart) {
  begin(1000);
  ASSERT_TRUE(say(sign(4, 'a')));
  end();
  begin(1);
  const auto silent = wait_for(1);
  ASSERT_EQ(silent.size(), 1U);
  EXPECT_EQ(silent[0].alarm.subject, "cell-a");
}

TEST_F(WatchdogTest, RefusesADoorThatOthersReachWithoutAToken) {
  WatchdogOptions options;
  options.listen = "0.0.0.0:0";
  options.heads = heads;
  const auto done = run_watchdog(
      std::move(options), taking, [](const std::string&) {}, [](const std::string&) {},
      [] { return true; });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "NEEDS_TLS");
}

}  // namespace
}  // namespace driftwise::watchdog
