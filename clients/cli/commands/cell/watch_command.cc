#include "clients/cli/commands/cell/watch_command.h"

#include <chrono>
#include <memory>
#include <thread>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/pages/live_picture.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/watch_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using Steady = std::chrono::steady_clock;
using WatchStub = v1::WatchService::Stub;
using std::chrono::seconds;

struct WatchArguments {
  std::vector<std::string> channels;
  double every_s = 10;
  bool once = false;
};

// The terminal's other screen, so that what stood before stands again afterwards.
class FullScreen {
 public:
  explicit FullScreen(std::ostream& out) : out_(out) {
    out_ << "\x1b[?1049h\x1b[?25l" << std::flush;
  }
  ~FullScreen() { out_ << "\x1b[?25h\x1b[?1049l" << std::flush; }
  FullScreen(const FullScreen&) = delete;
  FullScreen& operator=(const FullScreen&) = delete;
  void show(const std::string& screen) const {
    // Cleared before a line is written: behind one as wide as the window its last character would
    // go too.
    std::string text = "\x1b[H\x1b[K";
    const auto last = screen.rfind('\n');
    for (std::size_t i = 0; i < screen.size(); ++i) {
      text += screen[i];
      if (screen[i] == '\n') text += i == last ? "\x1b[J" : "\x1b[K";
    }
    out_ << text << std::flush;
  }

 private:
  std::ostream& out_;
};

class Watching {
 public:
  Watching(const Session& session, const WatchArguments& arguments)
      : session_(session),
        arguments_(arguments),
        connection_(session.connect()),
        picture_({arguments.channels.begin(), arguments.channels.end()}) {
    if (session.console.out_is_terminal && !session.console.json && !arguments.once)
      screen_ = std::make_unique<FullScreen>(session.console.out);
  }

  // Returns at --once, or when nobody reads what it writes; else it ends by Ctrl-C, or where nobody
  // looks (a pipe, a log) by a loss.
  ExitCode run() {
    for (;;) {
      try {
        follow();
        if (!connection_.is_heard()) return ExitCode::done;
        if (const auto words = picture_.unknown(); !words.empty())
          throw Failure{
              ExitCode::bad_input, "not_found", "UNKNOWN_CHANNEL",
              "this cell has no channel '" + words.front() + "': `driftwise status` lists them"};
        if (done_) return ExitCode::done;
        trouble_ = "the daemon ended the stream; trying again";
      } catch (const Failure& failure) {
        if (failure.reason == "CURSOR_TOO_OLD") {
          cursor_.clear();
          continue;
        }
        if (!screen_ || failure.exit != ExitCode::unreachable) throw;
        trouble_ = failure.message + " Trying again.";
      }
      draw();
      pause();
    }
  }

 private:
  void follow() {
    v1::WatchRequest request;
    request.set_cursor(cursor_);
    request.set_max_hz(screen_ ? 5 : 1);
    if (!session_.console.json)
      for (const auto topic : {v1::TOPIC_CELL, v1::TOPIC_VALUES, v1::TOPIC_RUNS, v1::TOPIC_ALARMS})
        request.add_topics(topic);
    connection_.follow(&WatchStub::Watch, request,
                       [this](const v1::WatchResponse& batch) { return take(batch); });
  }

  bool take(const v1::WatchResponse& batch) {
    cursor_ = batch.cursor();
    trouble_.clear();
    if (session_.console.json) {
      session_.console.out << json_from(batch).dump() << '\n' << std::flush;
      return !(done_ = arguments_.once);
    }
    picture_.take(batch);
    if (const auto words = picture_.unknown(); !words.empty())
      throw Failure{
          ExitCode::bad_input, "not_found", "UNKNOWN_CHANNEL",
          "this cell has no channel '" + words.front() + "': `driftwise status` lists them"};
    if (picture_.channels().empty()) return true;  // the layout comes first
    look_back();
    draw();
    return !(done_ = arguments_.once);
  }

  // The last ten minutes, for the sparklines: from the record, so that a new watcher sees them too.
  void look_back() {
    if ((!screen_ && !arguments_.once) || Steady::now() < next_look_back_) return;
    next_look_back_ = Steady::now() + seconds(5);
    const auto status = connection_.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{});
    v1::GetSeriesRequest request;
    for (const auto& channel : picture_.channels()) request.add_channels(channel);
    *request.mutable_to_time() = status.cell_time();
    *request.mutable_from_time() = status.cell_time();
    request.mutable_from_time()->set_seconds(status.cell_time().seconds() - 600);
    request.set_bucket_count(40);
    picture_.take(connection_.ask(&WatchStub::GetSeries, request));
  }

  void draw() {
    const Console& console = session_.console;
    if (screen_) {
      screen_->show(picture_.screen(console.paint_out(),
                                    static_cast<std::size_t>(console.err_width),
                                    static_cast<std::size_t>(console.err_height), trouble_));
    } else if (arguments_.once) {
      console.out << picture_.screen(console.paint_out(), 120, 10000, trouble_) << '\n'
                  << std::flush;
    } else if (!console.json && Steady::now() >= next_line_) {
      next_line_ = Steady::now() +
                   std::chrono::milliseconds(static_cast<std::int64_t>(arguments_.every_s * 1e3));
      console.out << picture_.line() << '\n' << std::flush;
    }
  }

  void pause() const {
    for (int i = 0; i < 20; ++i) {
      if (connection_.interrupted())
        throw Failure{ExitCode::interrupted, "cancelled", "INTERRUPTED", "interrupted"};
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }

  const Session& session_;
  const WatchArguments& arguments_;
  Connection connection_;
  LivePicture picture_;
  std::unique_ptr<FullScreen> screen_;
  std::string cursor_, trouble_;
  bool done_ = false;
  Steady::time_point next_look_back_{}, next_line_{};
};

}  // namespace

void add_watch_command(CLI::App& app, Session& session) {
  auto a = std::make_shared<WatchArguments>();
  CLI::App& watch = add_command(app, session, "watch", "The cell, live in the terminal",
                                [&session, a] { return Watching(session, *a).run(); });
  watch.add_option("--channels", a->channels, "these only, such as x,t07; repeatable")
      ->delimiter(',');
  watch.add_option("--every", a->every_s, "seconds between two lines where there is no terminal")
      ->check(number_between(0.0, 86400.0))
      ->capture_default_str();
  watch.add_flag("--once", a->once, "show the first picture and end");
}

}  // namespace driftwise::cli
