#pragma once
// Doors of the text line over a model that serves, in a cell whose loopback asks for tokens.

#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <ctime>
#include <functional>
#include <future>
#include <stdexcept>
#include <thread>

#include "server/compensation/snapshot_builder.h"
#include "server/core/try.h"
#include "server/line/target_line_server.h"
#include "tests/support/manual_clock.h"
#include "tests/support/process.h"
#include "tests/support/tls_client.h"
#include "tests/unit/compensation/models.h"
#include "tests/unit/line/captured_log.h"
#include "tests/unit/line/line_client.h"

namespace driftwise::line {

class LineDoors : public testing::Test {
 protected:
  LineDoors() : work_(asio::make_work_guard(context_)), thread_([this] { context_.run(); }) {
    AccessDescription description;
    description.configured = true;
    description.loopback = LoopbackRule::token;
    access_ = *access::Access::open(description, folder_.path(), [this] { return utc_s_.load(); });
    auto builder = std::move(*compensation::SnapshotBuilder::create(
        compensation::axis_model(), ModelId{3}, compensation::axis_cell()));
    if (!board_.publish(builder.build(clock_.now().utc))) throw std::runtime_error("no snapshot");
  }
  ~LineDoors() override {
    on_executor([this] { server_.reset(); });
    work_.reset();
    thread_.join();
  }
  void on_executor(std::function<void()> work) {
    std::promise<void> done;
    asio::post(context_, [&] {
      work();
      done.set_value();
    });
    done.get_future().wait();
  }
  Result<void> start(LineDoor door) {
    DRIFTWISE_TRY(server_,
                  TargetLineServer::start(
                      {context_.get_executor(), context_.get_executor(), board_, clock_, *access_},
                      std::move(door)));
    return {};
  }
  LineDoor tls_door() const {
    auto material = tls::TlsMaterial::open(
        {certificates_.path("server.pem"), certificates_.path("server-key.pem"),
         certificates_.path("authority.pem")},
        tls::ClientCertificate::accepted);
    return {"127.0.0.1:0", LineKind::tls, std::move(*material)};
  }
  std::string token(const std::string& name, access::Role role) {
    return access_->tokens().create(name, role, "test", 0, std::nullopt)->text;
  }

  const tests::CapturedLog log_;
  asio::io_context context_;
  const tests::TemporaryFolder folder_;
  const tests::TestCertificates certificates_{folder_.path()};
  tests::ManualClock clock_;
  compensation::SnapshotBoard board_;
  std::atomic<std::int64_t> utc_s_{std::time(nullptr)};  // what ends, ends by this clock
  std::unique_ptr<access::Access> access_;
  std::unique_ptr<TargetLineServer> server_;
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  std::thread thread_;
};

}  // namespace driftwise::line
