#include "clients/cli/commands/cell/hold_commands.h"

#include <cmath>
#include <memory>
#include <sstream>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/cell_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using CellStub = v1::CellService::Stub;

struct Aside {
  std::string name, reason;
  double hours = 0;
  bool restore = false;
};

std::string quantity_of(const v1::Hold& hold) {
  return hold.minus_channel().empty() ? hold.channel()
                                      : hold.channel() + " - " + hold.minus_channel();
}

std::string plain(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string limits_of(const v1::Hold& hold) {
  std::string text;
  if (hold.has_above()) text += " above " + plain(hold.above());
  if (hold.has_below()) text += (text.empty() ? " below " : " or below ") + plain(hold.below());
  return quantity_of(hold) + text;
}

std::string standing_of(const Paint& paint, const v1::Hold& hold) {
  if (hold.has_aside_until_time())
    return paint.warn("set aside") + " until " + utc_text(hold.aside_until_time()) + " by " +
           hold.aside_by() + ": " + hold.aside_reason();
  switch (hold.phase()) {
    case v1::Hold::PHASE_HOLDING:
      return paint.bad("holds") + " since " + utc_text(hold.begin_time()) + ": " + hold.sentence() +
             "; now " + hold.outlook();
    case v1::Hold::PHASE_EXCEEDED:
      return paint.warn("exceeded") + ": " + hold.outlook();
    default:
      return "met";
  }
}

ExitCode list_holds(const Session& session) {
  const auto response = session.connect().ask(&CellStub::ListHolds, v1::ListHoldsRequest());
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  const Paint paint = session.console.paint_out();
  for (const auto& hold : response.holds())
    session.console.out << hold.name() << "  (" << limits_of(hold) << ")\n    "
                        << standing_of(paint, hold) << '\n';
  if (response.holds().empty())
    session.console.out << "no [[hold]] in the cell file: docs/holds.md\n";
  return ExitCode::done;
}

ExitCode set_aside(const Session& session, const Aside& aside) {
  constexpr double kHour_s = 3600;
  v1::SetHoldAsideRequest request;
  request.set_name(aside.name);
  request.set_reason(aside.reason);
  if (!aside.restore)
    request.mutable_aside_duration()->set_seconds(std::llround(aside.hours * kHour_s));
  const auto response = session.connect().ask(&CellStub::SetHoldAside, request);
  if (session.console.json)
    session.console.print_json(json_from(response.hold()));
  else
    session.console.out << aside.name << ": "
                        << standing_of(session.console.paint_out(), response.hold()) << '\n';
  return ExitCode::done;
}

}  // namespace

void add_hold_commands(CLI::App& app, Session& session) {
  auto aside = std::make_shared<Aside>();
  const auto act = [&session, aside] {
    return aside->name.empty() ? list_holds(session) : set_aside(session, *aside);
  };
  CLI::App& holds =
      add_command(app, session, "hold", "Limits of the cell under which a run waits", act);
  // CLI11 calls the parent's action last: all are the same one.
  CLI::App& set = add_command(holds, session, "aside", "A limit suspends nothing for a while", act);
  set.add_option("NAME", aside->name, "as 'driftwise hold' lists it")->required();
  set.add_option("--hours", aside->hours, "for how long, cell time; at most a week")
      ->required()
      ->check(number_between(0.001, 168));
  set.add_option("--reason", aside->reason, "in writing; recorded")->required();
  CLI::App& restore = add_command(holds, session, "restore", "It counts again at once", act);
  restore.add_option("NAME", aside->name, "as 'driftwise hold' lists it")->required();
  restore.callback([&session, aside, act] {
    aside->restore = true;
    session.action = act;
  });
}

}  // namespace driftwise::cli
