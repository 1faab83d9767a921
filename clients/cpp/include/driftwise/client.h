#pragma once
// Driftwise for controllers in C++: compensated motor coordinates from a running daemon.
//
// Two ways. Client::target() asks once (about 0.15 ms over loopback). Client::follow() keeps the
// newest target of one pose at hand while temperatures move: TargetFollower::latest() answers from
// memory, takes a short lock, and never waits for the network: fit for a control loop.
//
// Nothing here moves anything but stop_all(), which halts. Failures are values with the daemon's
// own words and stable reason; nothing throws but std::bad_alloc.
//
// Thread: Client and TargetFollower may be used from several threads at once. C++17.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

namespace driftwise::client {

// reason: UPPER_SNAKE and stable, see docs/api.md ("NO_MODEL", "OUTSIDE_DOMAIN"); this library adds
// NO_DAEMON (no daemon answers at the address, or it ended meanwhile), BAD_CREDENTIALS (files that
// cannot be read, a token with blanks inside), TIMEOUT, NO_NOTICE and BAD_NOTICE (driftwised.json),
// NOT_YET (a follower has heard nothing yet) and EXPIRED (a follower has heard nothing for too
// long). message: a sentence for a person.
struct Failure {
  std::string reason, message;
};
template <class T>
using Answer = tl::expected<T, Failure>;

// By channel, with the unit in its name: {{"x_mm", 1.5}, {"force_N", 0}}. Every coordinate that the
// serving model needs, 0 included.
using Pose = std::vector<std::pair<std::string, double>>;

struct MotorCoordinate {
  std::string channel;     // "q1_mm"
  double position_mm = 0;  // move there, as read back from the scale
  double u90_nm = 0;       // 1.645 x standard uncertainty
  double expanded_nm = 0;  // k = 2
};

struct Target {
  std::vector<MotorCoordinate> coordinates;  // in order of the axes
  std::int64_t model_id = 0;
  // By the cell's clock, which is the wall clock unless the cell is simulated at another speed.
  std::chrono::system_clock::time_point conditions_time, valid_until;
  // "OUTSIDE_DOMAIN(x_mm+t07_degC)": what to know before moving there; none: nothing. As on the
  // text line, docs/target-line.md.
  std::vector<std::string> flags;
  bool plain() const { return flags.empty(); }
};

class TargetFollower {
 public:
  ~TargetFollower();  // ends the stream; does not wait for the network
  TargetFollower(TargetFollower&&) noexcept;
  TargetFollower& operator=(TargetFollower&&) noexcept;

  // The newest target, or why there is none now. When the daemon is lost this says NO_DAEMON, not
  // an old target; it connects again by itself, at most 2 s after the daemon is back. When the
  // daemon or the network falls silent it says EXPIRED as soon as the target has lived from its
  // conditions_time to its valid_until on this computer's own clock; sequence() then stays.
  Answer<Target> latest() const;
  std::uint64_t sequence() const;  // grows with every change of latest()
  // Returns when sequence() differs from `seen`, or at the time limit; the sequence then.
  std::uint64_t wait(std::uint64_t seen, std::chrono::milliseconds limit) const;

 private:
  friend class Client;
  struct State;
  explicit TargetFollower(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// What the daemon wants to see (docs/access.md). Nothing: a plain connection, which only loopback
// takes.
struct Credentials {
  std::filesystem::path authority;         // PEM: who signed the daemon's certificate; given: TLS
  std::filesystem::path certificate, key;  // PEM of a client certificate with a role; or
  std::string token;                       // "dwt_...", also with the line's end of its file
};

class Client {
 public:
  // address: "127.0.0.1:50051". operator_name stands in the record where nobody proves anything.
  // Connects when first asked, and again after a loss. Credentials that cannot be read or sent:
  // every call fails with BAD_CREDENTIALS.
  explicit Client(std::string address, std::string operator_name = "controller",
                  const Credentials& credentials = {});
  ~Client();
  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;

  Answer<Target> target(const Pose& pose,
                        std::chrono::milliseconds limit = std::chrono::seconds(1)) const;
  // min_interval: wall time between two answers; 0: with every change of the conditions. Longer
  // than a target lives it becomes half of that: else none would be good for most of the time.
  TargetFollower follow(Pose pose, std::chrono::milliseconds min_interval = {}) const;
  // Halts every axis; a run under way is paused. A stop by software. Failure STOP_NOT_CONFIRMED: a
  // controller has not reported that nothing moves: use the emergency switch. The daemon goes on
  // stopping it. Every other failure: nothing was stopped, and its message begins with NOT STOPPED.
  Answer<void> stop_all(std::chrono::milliseconds limit = std::chrono::seconds(2)) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The address in the driftwised.json that the daemon keeps beside its cell file while it is ready.
Answer<std::string> address_in(const std::filesystem::path& driftwised_json);

}  // namespace driftwise::client
