// A joint target of two robots against the target of one three-axis model, in one run: over the
// text line, with the floor of both (a server that answers a line of the same length with bytes of
// the same length and computes nothing), and in process, part by part. Sizes: every motor model and
// the predicted tilts have poly(a, b, c, 3), the single model and the Micro-Nano seven
// temperatures; the MinAngle is a blend asked in its band.
// A pair: the four kinds in turn, a hundred round trips each, until each has its number: what else
// the machine does meets all four. Ratios are taken within a pair. Prints one JSON object; goal:
// line_p99_ratio, the median over the pairs, at most 1.3.
//   taskset -c 1 build/release/bin/joint_target_bench [round trips of a kind in a pair, default
//   5000] [pairs, default 15]

#include <algorithm>
#include <array>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/compensation/snapshot_builder.h"
#include "server/formats/export/target_line.h"
#include "server/line/target_line_server.h"
#include "server/plans/joint_target.h"
#include "tests/support/manual_clock.h"
#include "tests/unit/plans/two_robots.h"

namespace {

using namespace driftwise;
using namespace driftwise::plans;
using asio::ip::tcp;
using boost::system::error_code;
using Steady = std::chrono::steady_clock;

constexpr int kBlock = 100;  // round trips of one kind in a row

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

CellDescription one_robot_cell() {
  CellDescription cell = two_robot_cell();
  for (auto& device : cell.devices)
    if (device.id == "hexapod") {
      auto& axes = device.become<MotionSettings>().axes;
      axes.clear();
      for (const char* name : {"q1", "q2", "q3"})
        axes.push_back({.channel = {name, "mm"},
                        .device_axis = "X",
                        .min_mm = -4,
                        .max_mm = 4,
                        .u_scale_nm = 3});
    }
  return cell;
}

compensation::Snapshot single_snapshot(CellTime now) {
  auto builder = std::move(*compensation::SnapshotBuilder::create(
      cubic_model(motors(""), lengths(""), true), ModelId{1}, one_robot_cell()));
  builder.keep_model_datum();
  builder.observe(temperatures(), now);
  return builder.build(now);
}

constexpr std::string_view kSingleLine = "TARGET x_mm=0.5 y_mm=0.5 z_mm=0.5 u=1\n";
constexpr std::string_view kJointLine =
    "JOINT mn.x_mm=0.5 mn.y_mm=0.5 mn.z_mm=0.5 ma.rx_arcsec=325 ma.ry_arcsec=10 ma.z_mm=0.5 u=1\n";

std::string_view without_end(std::string_view line) { return line.substr(0, line.size() - 1); }

// A floor: the same bytes both ways, in the server's style (callbacks, one read, one write).
class Echo : public std::enable_shared_from_this<Echo> {
 public:
  Echo(tcp::socket socket, std::string answer)
      : socket_(std::move(socket)), answer_(std::move(answer)) {
    socket_.set_option(tcp::no_delay(true));
  }
  void read_on() {
    socket_.async_read_some(asio::buffer(in_),
                            [self = shared_from_this()](error_code error, std::size_t) {
                              if (!error)
                                asio::async_write(self->socket_, asio::buffer(self->answer_),
                                                  [self](error_code failed, std::size_t) {
                                                    if (!failed) self->read_on();
                                                  });
                            });
  }

 private:
  tcp::socket socket_;
  std::array<char, 2048> in_;
  std::string answer_;
};

class Client {
 public:
  Client(std::uint16_t port, std::string_view request) : socket_(context_), request_(request) {
    socket_.connect(tcp::endpoint(asio::ip::address_v4::loopback(), port));
    socket_.set_option(tcp::no_delay(true));
  }
  double round_trip_us() {
    const auto start = Steady::now();
    asio::write(socket_, asio::buffer(request_.data(), request_.size()));
    size_ = 0;
    do size_ += socket_.read_some(asio::buffer(answer_.data() + size_, answer_.size() - size_));
    while (answer_[size_ - 1] != '\n');
    const auto took = Steady::now() - start;
    if (answer().substr(0, 2) != "OK") std::abort();
    return std::chrono::duration<double, std::micro>(took).count();
  }
  std::string_view answer() const { return {answer_.data(), size_}; }
  std::size_t request_bytes() const { return request_.size(); }

 private:
  asio::io_context context_;
  tcp::socket socket_;
  std::string_view request_;
  std::array<char, 4096> answer_;
  std::size_t size_ = 0;
};

double quantile(std::vector<double> values, double q) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

constexpr std::array<double, 3> kQuantiles = {0.5, 0.9, 0.99};
constexpr std::array<const char*, 3> kQuantileNames = {"p50", "p90", "p99"};

// Quantiles of the kinds, by pair.
struct Kind {
  const char* name;
  std::unique_ptr<Client> client;
  std::array<std::vector<double>, 3> by_pair{};
};

void run_pair(std::span<Kind> kinds, int round_trips, bool backwards) {
  std::vector<std::vector<double>> times(kinds.size());
  for (int done = 0; done < round_trips; done += kBlock)
    for (std::size_t turn = 0; turn < kinds.size(); ++turn) {
      const std::size_t k = backwards ? kinds.size() - 1 - turn : turn;
      for (int i = 0; i < kBlock; ++i) times[k].push_back(kinds[k].client->round_trip_us());
    }
  for (std::size_t k = 0; k < kinds.size(); ++k)
    for (std::size_t q = 0; q < kQuantiles.size(); ++q)
      kinds[k].by_pair[q].push_back(quantile(times[k], kQuantiles[q]));
}

// "line_p99_ratio": median over the pairs, its quartiles and its ends.
void print_ratio(const char* name, const Kind& over, const Kind& under, std::size_t q) {
  std::vector<double> ratios;
  for (std::size_t pair = 0; pair < over.by_pair[q].size(); ++pair)
    ratios.push_back(over.by_pair[q][pair] / under.by_pair[q][pair]);
  std::printf(
      ", \"%s_%s_ratio\": %.3f, \"%s_%s_ratio_quartiles\": [%.3f, %.3f], "
      "\"%s_%s_ratio_range\": [%.3f, %.3f]",
      name, kQuantileNames[q], quantile(ratios, 0.5), name, kQuantileNames[q],
      quantile(ratios, 0.25), quantile(ratios, 0.75), name, kQuantileNames[q], quantile(ratios, 0),
      quantile(ratios, 1));
}

// ns of one call: the median of many hundreds.
template <class Once>
double cost_ns(int samples, const Once& once) {
  std::vector<double> found;
  for (int sample = 0; sample < std::max(20, samples / kBlock); ++sample) {
    const auto start = Steady::now();
    for (int i = 0; i < kBlock; ++i) once();
    found.push_back(std::chrono::duration<double, std::nano>(Steady::now() - start).count() /
                    kBlock);
  }
  return quantile(found, 0.5);
}

// In process: what the server does between its read and its write.
double print_parts(int samples, const compensation::Snapshot& single, const JointSnapshot& joint) {
  double sum = 0;
  std::string text;
  text.reserve(formats::kMaxTargetAnswer);
  const auto one = *formats::parse_target_line(without_end(kSingleLine));
  const auto both = *formats::parse_joint_line(without_end(kJointLine), joint);
  const auto target = compensation::compute_target(single, one);
  const auto joint_target = compute_joint_target(joint, both);
  const double parse = cost_ns(
      samples, [&] { sum += formats::parse_target_line(without_end(kSingleLine))->value[0]; });
  const double joint_parse = cost_ns(samples, [&] {
    sum += formats::parse_joint_line(without_end(kJointLine), joint)->value[0][0];
  });
  const double compute =
      cost_ns(samples, [&] { sum += compensation::compute_target(single, one).u_nm[0]; });
  const double joint_compute =
      cost_ns(samples, [&] { sum += compute_joint_target(joint, both).u_nm[0]; });
  const double write = cost_ns(samples, [&] {
    text.clear();
    formats::append_target_answer(text, single, target, true);
    sum += static_cast<double>(text.size());
  });
  const double joint_write = cost_ns(samples, [&] {
    text.clear();
    formats::append_joint_answer(text, joint, joint_target, true);
    sum += static_cast<double>(text.size());
  });
  std::printf(
      ", \"process_single_ns\": {\"parse\": %.0f, \"compute\": %.0f, \"write\": %.0f}, "
      "\"process_joint_ns\": {\"parse\": %.0f, \"compute\": %.0f, \"write\": %.0f}",
      parse, compute, write, joint_parse, joint_compute, joint_write);
  return sum;
}

}  // namespace

int main(int argc, char** argv) {
  const int round_trips = argc > 1 ? std::max(kBlock, std::atoi(argv[1])) : 5000;
  const int pairs = argc > 2 ? std::max(1, std::atoi(argv[2])) : 15;
  const tests::ManualClock clock;
  const auto now = clock.now().utc;
  compensation::SnapshotBoard board;
  JointBoard joint_board;
  if (!board.publish(single_snapshot(now)) || !joint_board.publish(joint_snapshot(now))) return 1;

  asio::io_context context;
  const auto work = asio::make_work_guard(context);
  const auto access = *access::Access::open({}, "/nonexistent");  // an open loopback, no tokens
  auto server = std::move(*line::TargetLineServer::start(
      {context.get_executor(), context.get_executor(), board, clock, *access, &joint_board},
      {"127.0.0.1:0"}));
  const auto& address = server->address();
  const auto port = static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
  tcp::acceptor acceptor(context, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  const auto echo_port = acceptor.local_endpoint().port();
  std::thread thread([&] { context.run(); });

  // A connection to a server that gives this answer, whatever it reads.
  const auto floor_of = [&](std::string_view request, std::string_view answer) {
    asio::post(context, [&acceptor, answer = std::string(answer)] {
      acceptor.async_accept([answer](error_code error, tcp::socket socket) {
        if (!error) std::make_shared<Echo>(std::move(socket), answer)->read_on();
      });
    });
    return std::make_unique<Client>(echo_port, request);
  };
  auto single = std::make_unique<Client>(port, kSingleLine);
  auto joint = std::make_unique<Client>(port, kJointLine);
  single->round_trip_us(), joint->round_trip_us();
  auto floor_single = floor_of(kSingleLine, single->answer());
  auto floor_joint = floor_of(kJointLine, joint->answer());
  std::array<Kind, 4> kinds = {Kind{"floor_single", std::move(floor_single)},
                               Kind{"single", std::move(single)}, Kind{"joint", std::move(joint)},
                               Kind{"floor_joint", std::move(floor_joint)}};
  run_pair(kinds, 1000, false);  // warm
  for (auto& kind : kinds) kind.by_pair = {};
  for (int pair = 0; pair < pairs; ++pair) run_pair(kinds, round_trips, pair % 2 != 0);

  std::printf("{\"pairs\": %d, \"round_trips\": %d", pairs, round_trips);
  for (const auto& kind : kinds) {
    std::printf(", \"%s_bytes\": [%zu, %zu]", kind.name, kind.client->request_bytes(),
                kind.client->answer().size());
    for (std::size_t q = 0; q < kQuantiles.size(); ++q)
      std::printf(", \"%s_%s_us\": %.2f", kind.name, kQuantileNames[q],
                  quantile(kind.by_pair[q], 0.5));
  }
  for (std::size_t q = 0; q < kQuantiles.size(); ++q) print_ratio("line", kinds[2], kinds[1], q);
  for (std::size_t q = 0; q < kQuantiles.size(); ++q) print_ratio("floor", kinds[3], kinds[0], q);
  const double sum = print_parts(20 * round_trips, *board.read(), *joint_board.read());
  std::printf("}\n");
  asio::post(context, [&] {
    server.reset();
    acceptor.close();
    context.stop();
  });
  thread.join();
  return sum > 0 ? 0 : 1;
}
