#include "drivers/simulated/emulators/cell/cell_server.h"

#include <algorithm>

namespace driftwise::simulated {
namespace {

// The daemon may change the speed while we wait: with a shared clock no wait is longer than this.
constexpr std::chrono::milliseconds kLongestSharedWait{5};
// Without anything to do the plant still moves on in small steps: an idle hour must not block the
// next reply.
constexpr TimeNs kIdleStep = kSecondNs;
constexpr int kControlClients = 16;

}  // namespace

CellServer::CellServer(boost::asio::io_context& io, Plant& plant, SimClock& clock,
                       const CellOutline& outline, const EmulatorOptions& options, FaultHooks hooks,
                       Options how)
    : io_(io),
      plant_(plant),
      clock_(clock),
      wire_(options.wire(how.seed)),
      bench_(plant),
      timer_(io) {
  bench_.set_deliver([this](std::size_t device, Session session, std::string bytes) {
    servers_[device]->send(session, std::move(bytes));
  });
  const TimeNs now = clock_.now();
  for (const auto& device : outline.devices) {
    const Switches& switches = options.of(device.id);
    const EmulatorKind& kind =
        *find_emulator_kind(device.kind);  // EmulatorOptions has refused others
    if (kind.is_shared_by_address) {
      const auto first = std::ranges::find_if(outline.devices, [&device](const auto& other) {
        return other.kind == device.kind && other.address == device.address;
      });
      if (first->id != device.id) {
        const auto served = std::ranges::find_if(
            addresses_, [&first](const auto& one) { return one.first == first->id; });
        const std::string address = served->second;
        addresses_.emplace_back(device.id, address);
        continue;
      }
    }
    const bool serial =
        !kind.serial_switch.empty() && switches.flag(std::string(kind.serial_switch));
    serve(device.id, kind.make(plant_, switches, places_, now),
          how.free_ports ? "127.0.0.1:0" : device.address, switches.integer("max_clients", 1, 1000),
          serial);
  }
  hooks.drop = [this](std::size_t device, double refuse_s) {
    servers_[device]->refuse_until(
        std::chrono::steady_clock::now() +
        std::chrono::nanoseconds(nanoseconds_from(refuse_s / clock_.speed())));
    // Later: the desk may be asked to drop the very connection it is answering on.
    boost::asio::post(io_, [this, device] { servers_[device]->drop_all(); });
  };
  hooks.pass = [this](double for_s) { return pass(for_s); };
  serve("control", std::make_unique<FaultDesk>(bench_, std::move(hooks)), "127.0.0.1:0",
        kControlClients, false);
}

CellServer::~CellServer() = default;

void CellServer::serve(const std::string& id, std::unique_ptr<Emulator> emulator,
                       const std::string& address, int max_clients, bool serial) {
  const std::size_t device = bench_.add(id, std::move(emulator));
  const int counts = id == "control" ? 0 : 1;
  StreamServer::Handler handler{
      .opened =
          [this, device, counts](Session session, Link link) {
            connected_ += counts;
            bench_.open(device, session, link, clock_.now());
          },
      .closed =
          [this, device, counts](Session session) {
            connected_ -= counts;
            bench_.close(device, session, clock_.now());
          },
      .received = [this, device](Session session,
                                 std::string_view bytes) { received(device, session, bytes); }};
  servers_.push_back(std::make_unique<StreamServer>(io_, std::move(handler), wire_, device + 1));
  try {
    addresses_.emplace_back(id, servers_.back()->listen(address, max_clients));
    if (serial) addresses_.emplace_back(id + "-serial", servers_.back()->open_serial());
  } catch (const SetupError& error) {
    throw SetupError("device '" + id + "': " + error.what());
  }
}

void CellServer::received(std::size_t device, Session session, std::string_view bytes) {
  bench_.receive(device, session, bytes, clock_.now());
  wake();
}

std::string CellServer::pass(double for_s) {
  if (connected_ > 0)
    return std::to_string(connected_) +
           " connections to devices are open, whose clock would jump: end the daemon first";
  if (!clock_.shared()) return "this cell runs on the computer's own time: start it with --speed";
  const TimeNs from = clock_.now(), until = from + nanoseconds_from(for_s);
  // In steps, as without this: the devices' own events and the plant's log stay as fine.
  for (TimeNs at = from; at < until; at += kIdleStep) bench_.run_until(at);
  bench_.run_until(until);
  clock_.set_forward(until);
  return "";
}

void CellServer::start() {
  started_ = true;
  wake();
}

void CellServer::stop() {
  started_ = false;
  timer_.cancel();
}

void CellServer::wake() {
  if (!started_) return;
  const TimeNs now = clock_.now();
  bench_.run_until(now);
  const TimeNs next = std::min(bench_.next_event().value_or(now + kIdleStep), now + kIdleStep);
  std::chrono::nanoseconds wait = clock_.wall_until(next);
  if (clock_.shared()) wait = std::min<std::chrono::nanoseconds>(wait, kLongestSharedWait);
  timer_.expires_after(wait);
  timer_.async_wait([this](boost::system::error_code error) {
    if (!error) wake();
  });
}

}  // namespace driftwise::simulated
