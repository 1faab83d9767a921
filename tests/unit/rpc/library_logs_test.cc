// Lines of gRPC's own log, as its threads write them.

#include "server/rpc/server/library_logs.h"

#include <gmock/gmock.h>
#include <grpc/support/log.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace driftwise::rpc {
namespace {

class LibraryLogs : public testing::Test {
 protected:
  LibraryLogs() {
    auto logger = std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log_));
    logger->set_pattern("%l: %v");
    spdlog::set_default_logger(std::move(logger));
    gpr_set_log_verbosity(GPR_LOG_SEVERITY_ERROR);  // what grpc_init() begins with
    take_over_library_logs();
  }
  ~LibraryLogs() override { spdlog::set_default_logger(before_); }

  static void fail_a_handshake() {
    gpr_log(__FILE__, __LINE__, GPR_LOG_SEVERITY_ERROR, "%s",
            "Handshake failed with fatal error SSL_ERROR_SSL: error:0A000086:SSL "
            "routines::certificate verify failed.");
  }
  std::vector<std::string> lines() const {
    std::istringstream text(log_.str());
    std::vector<std::string> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }

 private:
  std::ostringstream log_;
  std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
};

TEST_F(LibraryLogs, OfAFailedHandshakeAreAWarningThatNamesTheClient) {
  note_tls_client("ipv4:192.0.2.7");
  fail_a_handshake();
  ASSERT_EQ(lines().size(), 1u);
  EXPECT_THAT(lines().front(),
              testing::StartsWith("warning: gRPC door: the TLS handshake with ipv4:192.0.2.7 "
                                  "failed: certificate verify failed; the client's certificate "
                                  "has ended"));
}

TEST_F(LibraryLogs, OfManyThreadsWarnOncePerClient) {
  const auto knock = [](const std::string& host) {
    for (int i = 0; i < 500; ++i) {
      note_tls_client(host);
      fail_a_handshake();
      gpr_log(__FILE__, __LINE__, GPR_LOG_SEVERITY_ERROR, "%s", "something else");
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back(knock, "ipv4:198.51.100." + std::to_string(i));
  for (auto& thread : threads) thread.join();
  EXPECT_GE(lines().size(), 1u);
  EXPECT_LE(lines().size(), 4u) << "once a minute and client; anything else is at debug";
}

}  // namespace
}  // namespace driftwise::rpc
