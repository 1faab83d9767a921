#pragma once
// The command line driven as a person drives it, against a real server over a real cell.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "clients/cli/cli.h"
#include "server/rpc/server/rpc_server.h"
#include "tests/support/fakes.h"
#include "tests/support/process.h"

namespace driftwise::tests {

using testing::HasSubstr;

class CliTest : public testing::Test {
 protected:
  // diagnose: in the place of the search for causes.
  explicit CliTest(app::Diagnose diagnose = {}) : cell(std::move(diagnose)) {}
  struct Outcome {
    int exit = -1;
    std::string out, err;
  };

  void SetUp() override {
    auto opened = rpc::RpcServer::open(cell.services(fakes), "127.0.0.1:0");
    if (!opened) throw std::runtime_error(opened.error().message);
    server = std::move(*opened);
    server->ready(true);
    environment = {{"DRIFTWISE_SERVER", server->address()}, {"USER", "ada"}};
  }
  void TearDown() override { server.reset(); }

  // answer: what a person types at a terminal when asked; none: nobody is there.
  Outcome run(std::vector<std::string> arguments, bool terminal = false,
              std::optional<std::string> answer = std::nullopt) {
    std::ostringstream out, err;
    std::istringstream in(answer.value_or(""));
    cli::Console console{out,
                         err,
                         terminal,
                         terminal,
                         80,
                         environment,
                         folder.path(),
                         false,
                         24,
                         answer ? &in : nullptr,
                         answer.has_value()};
    const int exit = cli::run_cli(std::move(arguments), console);
    return {exit, out.str(), err.str()};
  }
  nlohmann::json json(std::vector<std::string> arguments) {
    arguments.push_back("--json");
    const Outcome outcome = run(std::move(arguments));
    EXPECT_EQ(outcome.exit, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }
  std::string file(const std::string& name, const std::string& text) {
    const std::string path = folder.path() + "/" + name;
    std::ofstream(path) << text;
    return path;
  }

  TemporaryFolder folder;
  LiveCell cell;
  Fakes fakes;  // set by the test's constructor
  std::unique_ptr<rpc::RpcServer> server;
  std::map<std::string, std::string> environment;
};

}  // namespace driftwise::tests
