#include "clients/cli/commands/targets/simulate_command.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "clients/cli/commands/targets/target_command.h"
#include "clients/cli/core/assignment.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "driftwise/v1/target_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using TargetStub = v1::TargetService::Stub;

// Lengths of a pose in mm, their uncertainty and discrepancy in nm; rotations in arcsec.
struct InUnits {
  explicit InUnits(const std::string& channel) : length(channel.ends_with("_mm")) {}
  bool length;
  std::string value(double v) const { return length ? fixed(v, 7) + " mm" : fixed(v, 3) + unit; }
  std::string small(double v) const {
    return length ? fixed(v * 1e6, 1) + " nm" : fixed(v, 3) + unit;
  }
  std::string difference(double v) const {
    return length ? signed_fixed(v * 1e6, 1) + " nm" : signed_fixed(v, 3) + unit;
  }
  static constexpr const char* unit = " arcsec";
};

// Without an uncertainty nothing says how far the two may differ.
bool is_judged(const v1::EstimatedCoordinate& coordinate) { return std::isfinite(coordinate.u()); }

void print_pose(const Console& console, const v1::EstimatePoseResponse& pose) {
  Table table({{"pose"},
               {"simulated", Align::right},
               {"U (k=2)", Align::right},
               {"measured", Align::right},
               {"discrepancy", Align::right},
               {""}});
  for (const auto& coordinate : pose.coordinates()) {
    const InUnits in(coordinate.channel());
    const bool measured = coordinate.has_measured();
    table.add({coordinate.channel().substr(0, coordinate.channel().rfind('_')),
               in.value(coordinate.value()),
               is_judged(coordinate) ? in.small(2 * coordinate.u()) : "-",
               measured ? in.value(coordinate.measured()) : "-",
               measured ? in.difference(coordinate.discrepancy()) : "-",
               !measured || !is_judged(coordinate) ? ""
               : coordinate.agrees()               ? "within U"
                                                   : "beyond U"});
  }
  table.print(console.out, console.paint_out());
  console.out << "from";
  for (const auto& value : pose.motor())
    console.out << ' ' << value.channel() << ' ' << fixed(value.value(), 7);
  console.out << "; model " << pose.model_id() << ", conditions of "
              << clock_text(pose.conditions_time()) << " UTC\n";
  v1::Target flags;
  *flags.mutable_flags() = pose.flags();
  *flags.mutable_outside_channels() = pose.outside_channels();
  *flags.mutable_ignored_channels() = pose.ignored_channels();
  print_flags(console, flags);
}

}  // namespace

void add_simulate_command(CLI::App& app, Session& session) {
  auto values = std::make_shared<std::vector<std::string>>();
  CLI::App& command = *app.add_subcommand("simulate",
                                          "Where the end-effector is, by the model that serves, "
                                          "and what an instrument reads beside it");
  command.add_option("VALUE", *values,
                     "q1=1.5 ...: motor coordinates, else those of now; force=0.3, rx=2 ...: what "
                     "the motors do not decide");
  command.callback([&session, values] {
    session.action = [&session, values] {
      v1::EstimatePoseRequest request;
      for (auto& value : assignments_from(*values))
        *(value.channel().starts_with("q") ? request.add_motor() : request.add_stated()) = value;
      const auto pose = session.connect().ask(&TargetStub::EstimatePose, request);
      if (session.console.json)
        session.console.print_json(json_from(pose));
      else
        print_pose(session.console, pose);
      return std::all_of(pose.coordinates().begin(), pose.coordinates().end(),
                         [](const auto& one) {
                           return !one.has_measured() || !is_judged(one) || one.agrees();
                         })
                 ? ExitCode::done
                 : ExitCode::negative;
    };
  });
}

}  // namespace driftwise::cli
