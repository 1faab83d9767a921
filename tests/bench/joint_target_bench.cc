// A joint target of two robots against the target of one three-axis model, in one run: computed in
// process, and asked over the text line, seven interleaved pairs. Sizes: every motor model and the
// predicted tilts have poly(a, b, c, 3), the single model and the Micro-Nano seven temperatures;
// the MinAngle is a blend asked in its band. Prints one JSON line; goal: p99 over the line at
// most 1.3 x that of the single one (median over the pairs).
//   taskset -c 1 build/release/bin/joint_target_bench [round trips per half pair, default 5000]

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "server/compensation/snapshot_builder.h"
#include "server/line/target_line_server.h"
#include "server/plans/joint_target.h"
#include "tests/support/manual_clock.h"
#include "tests/unit/plans/two_robots.h"

namespace {

using namespace driftwise;
using namespace driftwise::plans;
using asio::ip::tcp;
using compensation::Variable;
using Steady = std::chrono::steady_clock;

constexpr int kPairs = 7;

struct Input {
  std::string symbol, unit;
  double min, max;
};

// poly(a, b, c, 3), and seven temperatures where they are wanted.
calibration::Model cubic_model(const std::vector<Channel>& outputs,
                               const std::vector<Input>& inputs, bool temperatures) {
  calibration::Model model;
  std::vector<effects::Term> terms;
  for (int i = 0; i <= 3; ++i)
    for (int j = 0; i + j <= 3; ++j)
      for (int k = 0; i + j + k <= 3; ++k) {
        effects::Term term;
        const int exponents[] = {i, j, k};
        for (std::size_t s = 0; s < 3; ++s)
          if (exponents[s] > 0)
            term.factors.emplace_back(effects::Power{inputs[s].symbol, exponents[s]});
        terms.push_back(std::move(term));
      }
  for (const auto& input : inputs)
    model.domain.push_back({{input.symbol, input.unit}, input.min, input.max});
  for (int t = 4; temperatures && t <= 10; ++t) {
    const std::string name = (t < 10 ? "t0" : "t") + std::to_string(t);
    terms.push_back({{effects::Power{name, 1}}});
    model.domain.push_back({{name, "degC"}, 19, 22});
  }
  for (const auto& channel : outputs) {
    calibration::OutputModel output;
    output.channel = channel;
    output.terms = terms;
    const auto size = static_cast<Eigen::Index>(terms.size());
    output.coefficients = Eigen::VectorXd::LinSpaced(size, 1e-9, 1e-8);
    output.covariance = Eigen::MatrixXd::Identity(size, size) * 1e-18;
    output.accuracy.rmse = 8e-6;
    model.outputs.push_back(std::move(output));
  }
  return model;
}

std::vector<Input> lengths(const std::string& id) {
  return {{id + "x", "mm", -2.5, 2.5}, {id + "y", "mm", -2.5, 2.5}, {id + "z", "mm", -2.5, 2.5}};
}
std::vector<Input> tilts(double reach) {
  return {{"ma.rx", "arcsec", -reach, reach},
          {"ma.ry", "arcsec", -reach, reach},
          {"ma.z", "mm", -4, 4}};
}
std::vector<Channel> motors(const std::string& id) {
  return {{id + "q1", "mm"}, {id + "q2", "mm"}, {id + "q3", "mm"}};
}

std::vector<ChannelValue> temperatures() {
  std::vector<ChannelValue> values;
  for (int t = 4; t <= 10; ++t)
    values.push_back({(t < 10 ? "t0" : "t") + std::to_string(t) + "_degC", 20.5});
  return values;
}

JointSnapshot joint_snapshot(CellTime now) {
  const ModelsById models = {
      {kMicroNano, cubic_model(motors("mn."), lengths("mn."), true)},
      {kFine, cubic_model(motors("ma."), tilts(300), false)},
      {kCoarse, cubic_model(motors("ma."), tilts(18'000), false)},
      {kMinAngleMotion, min_angle_motion()},
      {kMicroNanoTilt, cubic_model({{"mn.rx", "arcsec"}, {"mn.ry", "arcsec"}, {"mn.rz", "arcsec"}},
                                   lengths("mn."), false)}};
  auto builder =
      std::move(*JointBuilder::create(joint_plan(), PlanId{1}, models, two_robot_cell()));
  builder.anchor({}, [](ModelId) { return true; });
  builder.observe(temperatures(), now);
  return builder.build(now);
}

compensation::Snapshot single_snapshot(CellTime now) {
  auto builder = std::move(*compensation::SnapshotBuilder::create(
      cubic_model(motors(""), lengths(""), true), ModelId{1}, {}));
  builder.keep_model_datum();
  builder.observe(temperatures(), now);
  return builder.build(now);
}

struct Quantiles {
  double p50, p99;
};
template <class Once>
Quantiles measure(int times, const Once& once) {
  std::vector<double> found;
  for (int i = 0; i < times; ++i) {
    const auto start = Steady::now();
    once();
    found.push_back(std::chrono::duration<double, std::micro>(Steady::now() - start).count());
  }
  std::ranges::sort(found);
  return {found[found.size() / 2], found[found.size() * 99 / 100]};
}

class Client {
 public:
  explicit Client(std::uint16_t port) : socket_(context_) {
    socket_.connect(tcp::endpoint(asio::ip::address_v4::loopback(), port));
    socket_.set_option(tcp::no_delay(true));
  }
  void ask(std::string_view request) {
    asio::write(socket_, asio::buffer(request.data(), request.size()));
    char answer[2048];
    std::size_t size = 0;
    do size += socket_.read_some(asio::buffer(answer + size, sizeof answer - size));
    while (answer[size - 1] != '\n');
    if (std::string_view(answer, 2) != "OK") std::abort();
  }

 private:
  asio::io_context context_;
  tcp::socket socket_;
};

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// Interleaved pairs of two things: medians over the pairs, and of the ratio of their p99.
struct Compared {
  Quantiles single, joint;
  double ratio;
};
template <class Single, class Joint>
Compared compared(int times, const Single& single, const Joint& joint) {
  measure(times / 10 + 100, single), measure(times / 10 + 100, joint);  // warm
  std::vector<double> single_p50, single_p99, joint_p50, joint_p99, ratios;
  for (int pair = 0; pair < kPairs; ++pair) {
    Quantiles of_single{}, of_joint{};
    if (pair % 2 == 0) of_single = measure(times, single);
    of_joint = measure(times, joint);
    if (pair % 2 != 0) of_single = measure(times, single);
    single_p50.push_back(of_single.p50), single_p99.push_back(of_single.p99);
    joint_p50.push_back(of_joint.p50), joint_p99.push_back(of_joint.p99);
    ratios.push_back(of_joint.p99 / of_single.p99);
  }
  return {{median(single_p50), median(single_p99)},
          {median(joint_p50), median(joint_p99)},
          median(ratios)};
}

}  // namespace

int main(int argc, char** argv) {
  const int round_trips = argc > 1 ? std::max(100, std::atoi(argv[1])) : 5000;
  const tests::ManualClock clock;
  const auto now = clock.now().utc;
  compensation::SnapshotBoard board;
  JointBoard joint_board;
  if (!board.publish(single_snapshot(now)) || !joint_board.publish(joint_snapshot(now))) return 1;

  compensation::TargetRequest one;
  for (const auto v : {Variable::x, Variable::y, Variable::z}) one.set(v, 0.5);
  JointRequest both;
  for (const auto v : {Variable::x, Variable::y, Variable::z}) both.set(0, v, 0.5);
  both.set(1, Variable::rx, 325), both.set(1, Variable::ry, 10), both.set(1, Variable::z, 0.5);
  double sum = 0;
  const auto process = compared(
      round_trips,
      [&] {
        const auto read = board.read();
        sum += compensation::compute_target(*read, one).u_nm[0];
      },
      [&] {
        const auto read = joint_board.read();
        sum += compute_joint_target(*read, both).u_nm[0];
      });

  asio::io_context context;
  const auto work = asio::make_work_guard(context);
  const auto access = *access::Access::open({}, "/nonexistent");  // an open loopback, no tokens
  auto server = std::move(*line::TargetLineServer::start(
      {context.get_executor(), context.get_executor(), board, clock, *access, &joint_board},
      {"127.0.0.1:0"}));
  std::thread thread([&] { context.run(); });
  const auto& address = server->address();
  Client client(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  const auto line = compared(
      round_trips, [&] { client.ask("TARGET x_mm=0.5 y_mm=0.5 z_mm=0.5 u=1\n"); },
      [&] {
        client.ask(
            "JOINT mn.x_mm=0.5 mn.y_mm=0.5 mn.z_mm=0.5 ma.rx_arcsec=325 ma.ry_arcsec=10 "
            "ma.z_mm=0.5 u=1\n");
      });
  std::printf(
      "{\"round_trips\": %d, \"process_single_p50_us\": %.2f, \"process_single_p99_us\": %.2f, "
      "\"process_joint_p50_us\": %.2f, \"process_joint_p99_us\": %.2f, \"line_single_p50_us\": "
      "%.1f, \"line_single_p99_us\": %.1f, \"line_joint_p50_us\": %.1f, \"line_joint_p99_us\": "
      "%.1f, \"process_p99_ratio\": %.2f, \"line_p99_ratio\": %.3f}\n",
      round_trips, process.single.p50, process.single.p99, process.joint.p50, process.joint.p99,
      line.single.p50, line.single.p99, line.joint.p50, line.joint.p99, process.ratio, line.ratio);
  asio::post(context, [&] {
    server.reset();
    context.stop();
  });
  thread.join();
  return sum > 0 ? 0 : 1;
}
