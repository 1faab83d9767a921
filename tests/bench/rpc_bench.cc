// A unary target against an empty unary call of the same server, over one loopback connection:
// seven interleaved pairs in one run. Prints one JSON line; goal: p99 at most 1.2 x the empty
// call's (median over the pairs). With "tls" both calls go through the door with TLS and show a
// token; goal: 1.5.
//   taskset -c 1 build/release/bin/rpc_bench [calls per half pair, default 5000] [tls]

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "driftwise/v1/target_service.grpc.pb.h"
#include "empty_service.grpc.pb.h"
#include "server/access/access.h"
#include "server/compensation/snapshot_builder.h"
#include "server/rpc/server/rpc_server.h"
#include "tests/support/fakes.h"
#include "tests/support/process.h"
#include "tests/unit/compensation/models.h"

namespace {

using namespace driftwise;

constexpr int kPairs = 7;

class EmptyService final : public bench::EmptyService::CallbackService {
  grpc::ServerUnaryReactor* Ask(grpc::CallbackServerContext* context,
                                const google::protobuf::Empty*, google::protobuf::Empty*) override {
    auto* reactor = context->DefaultReactor();
    reactor->Finish(grpc::Status::OK);
    return reactor;
  }
};

struct Quantiles {
  double p50_us, p99_us;
};

template <class Call>
Quantiles measure(Call call, int calls) {
  std::vector<double> times;
  for (int i = 0; i < calls; ++i) {
    const auto start = std::chrono::steady_clock::now();
    grpc::ClientContext context;
    if (!call(context)) std::exit(1);
    times.push_back(
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start)
            .count());
  }
  std::ranges::sort(times);
  return {times[times.size() / 2], times[times.size() * 99 / 100]};
}

// A certificate as openssl(1) makes it, good for 127.0.0.1.
std::unique_ptr<access::Access> with_certificate(const std::string& folder) {
  AccessDescription description;
  description.configured = true;
  description.certificate = folder + "/server.pem";
  description.key = folder + "/server.key";
  description.listen = "127.0.0.1:0";
  const auto made = tests::run_process(
      {"/usr/bin/openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
       "-nodes", "-keyout", description.key, "-out", description.certificate, "-days", "2", "-subj",
       "/CN=bench", "-addext", "subjectAltName=IP:127.0.0.1"});
  if (made.code != 0) throw std::runtime_error(made.err);
  return std::move(*access::Access::open(description, folder));
}

std::shared_ptr<grpc::ChannelCredentials> trusting(const std::string& folder) {
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = tests::read_file(folder + "/server.pem");
  return grpc::SslCredentials(options);
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const int calls = argc > 1 ? std::max(100, std::atoi(argv[1])) : 5000;
  tests::LiveCell cell;
  tests::FakeTargets served;
  auto builder = std::move(*compensation::SnapshotBuilder::create(
      compensation::axis_model(), ModelId{1}, compensation::axis_cell()));
  const CellTime now = cell.now();
  cell.on_executor([&] { served.publish(builder.build(now)); });
  EmptyService empty_service;
  const bool tls = argc > 2 && std::string(argv[2]) == "tls";
  const tests::TemporaryFolder folder;
  const auto access = tls ? with_certificate(folder.path()) : nullptr;
  const std::string token =
      tls ? access->tokens().create("bench", access::Role::controller, "bench", 0, {})->text : "";
  auto server = std::move(*rpc::RpcServer::open(cell.services({.targets = &served}), "127.0.0.1:0",
                                                {&empty_service}, access.get()));
  const auto channel =
      tls ? grpc::CreateChannel(server->tls_address(), trusting(folder.path()))
          : grpc::CreateChannel(server->address(), grpc::InsecureChannelCredentials());
  v1::TargetService::Stub targets(channel);
  bench::EmptyService::Stub empties(channel);

  v1::ComputeTargetRequest request;
  request.add_pose()->set_channel("x_mm");
  request.mutable_pose(0)->set_value(1.234567);
  const auto show = [&](grpc::ClientContext& context) {
    if (tls) context.AddMetadata("authorization", "Bearer " + token);
  };
  const auto target = [&](grpc::ClientContext& context) {
    v1::ComputeTargetResponse response;
    show(context);
    return targets.ComputeTarget(&context, request, &response).ok() &&
           response.target().coordinates_size() == 1;
  };
  const auto empty = [&](grpc::ClientContext& context) {
    google::protobuf::Empty response;
    show(context);
    return empties.Ask(&context, {}, &response).ok();
  };
  measure(target, 500), measure(empty, 500);  // warm

  std::vector<double> target_p50, target_p99, empty_p50, empty_p99, ratios;
  for (int pair = 0; pair < kPairs; ++pair) {
    const bool target_first = pair % 2 != 0;  // whoever comes first alternates
    Quantiles of_target{}, of_empty{};
    if (target_first) of_target = measure(target, calls);
    of_empty = measure(empty, calls);
    if (!target_first) of_target = measure(target, calls);
    target_p50.push_back(of_target.p50_us);
    target_p99.push_back(of_target.p99_us);
    empty_p50.push_back(of_empty.p50_us);
    empty_p99.push_back(of_empty.p99_us);
    ratios.push_back(of_target.p99_us / of_empty.p99_us);
  }
  std::printf(
      "{\"bench\": \"%s\", \"calls_per_half_pair\": %d, \"pairs\": %d, \"target_p50_us\": %.1f, "
      "\"target_p99_us\": %.1f, "
      "\"empty_p50_us\": %.1f, \"empty_p99_us\": %.1f, \"p99_ratio_median\": %.3f, \"goal\": "
      "%.1f}\n",
      tls ? "rpc_tls" : "rpc", calls, kPairs, median(target_p50), median(target_p99),
      median(empty_p50), median(empty_p99), median(ratios), tls ? 1.5 : 1.2);
  return 0;
}
