#include "clients/cpp/convert.h"
#include "clients/cpp/follower_state.h"
#include "driftwise/v1/target_service.grpc.pb.h"

namespace driftwise::client {

using std::chrono::milliseconds;

namespace {

// By the cell's clock from first to last: the clocks of daemon and controller need not agree. A
// target that is expired when it comes says so by a flag; it lives as long as one between two
// rebuilds of a daemon with its usual period.
std::chrono::steady_clock::duration lifetime_of(const Target& target) {
  constexpr std::chrono::seconds kOfExpired(10);
  const auto left = target.valid_until - target.conditions_time;
  if (left.count() <= 0) return kOfExpired;
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(left);
}

}  // namespace

TargetFollower::State::State(std::shared_ptr<Link> to, Pose pose, milliseconds min_interval)
    : link_(std::move(to)),
      pose_(std::move(pose)),
      min_interval_(min_interval),
      latest_(tl::unexpected(Failure{"NOT_YET", "no answer from " + link_->address + " yet"})) {
  thread_ = std::thread([this] { run(); });
}

TargetFollower::State::~State() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    if (open_ != nullptr) open_->TryCancel();
  }
  changed_.notify_all();
  thread_.join();
}

Answer<Target> TargetFollower::State::latest() const {
  const std::lock_guard lock(mutex_);
  if (latest_ && std::chrono::steady_clock::now() > expires_)
    return tl::unexpected(
        Failure{"EXPIRED", "the newest target is past its valid_until, and " + link_->address +
                               " has sent no other: the daemon or the network is silent"});
  return latest_;
}

std::uint64_t TargetFollower::State::sequence() const {
  const std::lock_guard lock(mutex_);
  return sequence_;
}

std::uint64_t TargetFollower::State::wait(std::uint64_t seen, milliseconds limit) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, limit, [&] { return sequence_ != seen || ending_; });
  return sequence_;
}

void TargetFollower::State::publish(Answer<Target> news) {
  {
    const std::lock_guard lock(mutex_);
    // A daemon that stays away is one piece of news, not one per attempt.
    if (!news && !latest_ && news.error().reason == latest_.error().reason) return;
    latest_ = std::move(news);
    if (latest_) expires_ = std::chrono::steady_clock::now() + lifetime_of(*latest_);
    ++sequence_;
  }
  changed_.notify_all();
}

bool TargetFollower::State::read_one_stream() {
  if (link_->trouble) {
    publish(tl::unexpected(*link_->trouble));
    return false;
  }
  grpc::ClientContext context;
  link_->sign(context);
  v1::WatchTargetsRequest request;
  put_pose(pose_, request);
  if (min_interval_.count() > 0) {
    auto& interval = *request.mutable_min_interval_duration();
    interval.set_seconds(min_interval_.count() / 1000);
    interval.set_nanos(static_cast<int>(min_interval_.count() % 1000) * 1'000'000);
  }
  {
    const std::lock_guard lock(mutex_);
    if (ending_) return false;
    open_ = &context;
  }
  const auto stub = v1::TargetService::NewStub(link_->channel);
  const auto reader = stub->WatchTargets(&context, request);
  v1::WatchTargetsResponse response;
  // An interval that outlives the targets would leave none for most of the time.
  bool is_too_slow = false;
  while (!is_too_slow && reader->Read(&response)) {
    const auto target = target_from(response.target());
    const auto lifetime = std::chrono::duration_cast<milliseconds>(lifetime_of(target));
    publish(target);
    is_too_slow = lifetime < min_interval_;
    if (is_too_slow) min_interval_ = lifetime / 2;
  }
  if (is_too_slow) context.TryCancel();
  const grpc::Status status = reader->Finish();
  {
    const std::lock_guard lock(mutex_);
    open_ = nullptr;
    if (ending_) return false;
  }
  if (is_too_slow) return true;
  publish(tl::unexpected(
      status.ok() ? Failure{"NO_DAEMON", "the daemon at " + link_->address + " ended the stream"}
                  : link_->failure_of(status)));
  return false;
}

void TargetFollower::State::run() {
  constexpr milliseconds kShortest(100), kLongest(2000);
  milliseconds pause = kShortest;
  for (;;) {
    const std::uint64_t before = sequence();
    if (read_one_stream()) continue;
    // A stream that gave a target was a good one: the next loss is looked at at once again.
    pause = sequence() > before + 1 ? kShortest : std::min(2 * pause, kLongest);
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, pause, [this] { return ending_; })) return;
  }
}

TargetFollower::TargetFollower(std::unique_ptr<State> state) : state_(std::move(state)) {}
TargetFollower::~TargetFollower() = default;
TargetFollower::TargetFollower(TargetFollower&&) noexcept = default;
TargetFollower& TargetFollower::operator=(TargetFollower&&) noexcept = default;
Answer<Target> TargetFollower::latest() const { return state_->latest(); }
std::uint64_t TargetFollower::sequence() const { return state_->sequence(); }
std::uint64_t TargetFollower::wait(std::uint64_t seen, milliseconds limit) const {
  return state_->wait(seen, limit);
}

}  // namespace driftwise::client
