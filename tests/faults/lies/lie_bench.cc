#include "tests/faults/lies/lie_bench.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "server/application/alarms/alarms.h"
#include "storage/sqlite_store.h"

namespace driftwise::lies {
namespace {

constexpr int kLines = 150, kPerLine = 4;  // three points and the return to zero
// Every line goes far, also behind the point after which a lie begins, and across. No line goes
// where one of the few before went: what a late readback says is false.
constexpr std::array<std::array<double, 3>, 3> kPlaces_mm = {
    {{1.0, 1.5, 2.0}, {2.0, 0.5, 0.5}, {0.5, 2.0, 0.5}}};

std::string trajectory_of(const CellDescription& cell) {
  const std::size_t axes = cell.motor_channels().size();
  const bool force = cell.load.has_value();
  std::ostringstream csv;
  for (std::size_t i = 0; i < axes; ++i) csv << 'q' << i + 1 << "_mm,";
  csv << "set,line,zero" << (force ? ",force_N" : "") << '\n';
  for (int line = 1; line <= kLines; ++line)
    for (int point = 1; point <= kPerLine; ++point) {
      const bool zero = point == kPerLine;
      for (std::size_t i = 0; i < axes; ++i)
        csv << (zero ? 0.0 : kPlaces_mm[static_cast<std::size_t>(point - 1)][i] + 0.02 * (line % 7))
            << ',';
      csv << (point == 2 ? "validation," : "calibration,") << line << ',' << (zero ? 1 : 0)
          << (force ? ",0" : "") << '\n';
    }
  return csv.str();
}

bool tells_of_a_lie(const std::string& what) {
  for (const char* kind : {"reading.", "pose.", "readback.", "zero.disagrees", "closure.bad"})
    if (what.starts_with(kind) && what != "reading.good_again") return true;
  return false;
}

const double* find(const std::vector<ChannelValue>& values, const std::string& channel) {
  const auto found = std::ranges::find(values, channel, &ChannelValue::channel);
  return found == values.end() ? nullptr : &found->value;
}

}  // namespace

LieBench::LieBench(const std::string& cell, std::uint64_t seed)
    : description_(tests::shipped_cell(cell, folder_ / "cell.db")),
      channels_(channels_of(description_)),
      world_(tests::make_plant_world(cell, tests::kWorldBegin, seed, true)) {
  cell_ = std::make_unique<tests::CellInMemory>(
      [this](tests::VirtualTime& time, const CellDescription& described) {
        return tests::plant_devices(world_, time, described);
      },
      description_,
      [](const std::string& path, bool read_only) {
        return storage::open_sqlite_store(path, read_only);
      },
      tests::CellInMemory::Further{});
  watches_.push_back(
      (*cell_)->feeds.watch_events([this](const EventRecord& event) { events_.push_back(event); }));
  watches_.push_back((*cell_)->runs.watch(
      [this](const application::RunProgress& progress) { progress_ = progress; }));
  begin_run();
}

LieBench::~LieBench() { watches_.clear(); }

void LieBench::begin_run() {
  if (run_ && cell_->status().run) {
    auto aborted = cell_->await((*cell_)->runs.abort(cell_->ada, *run_, "the next lies"));
    cell_->until([this] { return !cell_->status().run; });
    cell_->pass(10);  // the axes have confirmed that they were stopped
  }
  run_ = cell_->begin_run(trajectory_of(description_)).id;
  // The channels' own noise is known by then.
  cell_->until([this] {
    return progress_ && progress_->run.id == *run_ && progress_->run.accepted >= 2 * kPerLine;
  });
}

std::int64_t LieBench::rows_decided() const {
  return progress_ && run_ && progress_->run.id == *run_
             ? progress_->run.accepted + progress_->run.given_up
             : 0;
}

int LieBench::closures() const {
  return static_cast<int>(std::ranges::count(events_, "run.closure", &EventRecord::what));
}

void LieBench::come_to_mid_line() {
  cell_->lease();
  if (rows_decided() > (kLines - 60) * kPerLine || !cell_->status().run) begin_run();
  const auto from = rows_decided();
  cell_->until([this, from] {
    return progress_->run.state == RunState::running && rows_decided() > from &&
           progress_->run.place.next_row % kPerLine == 1;
  });
}

std::vector<AlarmRecord> LieBench::alarms_since(CellTime since) {
  auto all = cell_->await((*cell_)->alarms.list(true, 1000));
  if (!all) throw std::runtime_error(all.error().message);
  std::erase_if(*all, [since](const AlarmRecord& alarm) { return alarm.since < since; });
  return std::move(*all);
}

Episode LieBench::tell(const ChannelOfCell& channel, Kind kind, double size) {
  constexpr double kPatience_s = 1500, kStays_s = 20;
  come_to_mid_line();
  Episode episode;
  const CellTime from = cell_->now();
  const std::size_t first_event = events_.size();
  const int closures_before = closures();
  world_.liar.tell(channel.name, make_lie(world_, description_, channel, kind, size));
  const auto told = [this, first_event]() -> const EventRecord* {
    for (std::size_t i = first_event; i < events_.size(); ++i)
      if (tells_of_a_lie(events_[i].what)) return &events_[i];
    return nullptr;
  };
  const bool until_closure = !takes_answers(channel, kind);
  cell_->until(
      [&] {
        episode.waited = episode.waited || progress_->run.state == RunState::waiting;
        return told() || (until_closure && closures() > closures_before) ||
               seconds_from(cell_->now() - from) > kPatience_s;
      },
      2 * kPatience_s);
  // What is found with the closure is on record right behind it; then the lie goes on for a while.
  const CellTime stays_until = cell_->now() + nanoseconds_from_s(kStays_s);
  cell_->until([&] {
    episode.waited = episode.waited || progress_->run.state == RunState::waiting;
    return cell_->now() >= stays_until;
  });
  world_.liar.stop();
  if (const auto* event = told()) {
    episode.detected = true;
    episode.how = event->what;
    episode.said = event->detail;
    if (const auto first = world_.liar.first())
      episode.after_s = std::max(0.0, seconds_from(event->at.utc - *first));
    const auto closure =
        std::find_if(events_.begin() + static_cast<std::ptrdiff_t>(first_event), events_.end(),
                     [](const EventRecord& one) { return one.what == "run.closure"; });
    episode.after_closure = until_closure && closure != events_.end() &&
                            seconds_from(event->at.utc - closure->at.utc) > 1;
  }
  const auto decided = rows_decided();
  const double limit_s = 3600;
  const CellTime end_by = cell_->now() + nanoseconds_from_s(limit_s);
  const int closures_after = closures();
  cell_->until(
      [&] {
        return (rows_decided() >= decided + kPerLine && closures() > closures_after) ||
               cell_->now() > end_by;
      },
      2 * limit_s);
  episode.went_on = rows_decided() >= decided + kPerLine;
  cell_->pass(15);  // alarms of this lie are over before the next
  const auto alarms = alarms_since(from);
  episode.alarmed = std::ranges::any_of(
      alarms, [](const AlarmRecord& alarm) { return tells_of_a_lie(alarm.kind); });
  episode.alarm_stays = std::ranges::any_of(alarms, [](const AlarmRecord& alarm) {
    return tells_of_a_lie(alarm.kind) && alarm.cleared.utc_ns == 0;
  });
  look_at_rows(channel, from, episode);
  return episode;
}

void LieBench::look_at_rows(const ChannelOfCell& channel, CellTime from, Episode& episode) {
  const auto points = cell_->await(cell_->points(*run_, 0, 100'000));
  const auto data = cell_->await(cell_->datums(*run_));
  const auto state = cell_->await((*cell_)->annotations.exclusions(*run_));
  if (!points || !data || !state) throw std::runtime_error("the run cannot be read");
  const std::set<std::int64_t> suspect(state->suspect_rows.begin(), state->suspect_rows.end());
  for (const auto& point : *points) {
    if (point.measured.utc < from) continue;
    episode.suspect_rows += suspect.contains(point.row) ? 1 : 0;
    const auto underscore = channel.name.rfind('_');
    const double* value = nullptr;
    if (channel.what == What::length)  // as the interferometer gave it
      value = find(point.values,
                   channel.name.substr(0, underscore) + "_path" + channel.name.substr(underscore));
    if (!value) value = find(point.values, channel.name);
    if (!value) continue;
    double zero = 0;
    if (channel.what == What::angle)
      for (const auto& datum : *data)
        if (datum.id == point.datum)
          if (const double* at_zero = find(datum.values, channel.name)) zero = *at_zero;
    const double truth = world_.liar.truth(channel.name, point.measured.utc);
    if (std::abs(*value + zero - truth) <= tolerance(channel)) continue;
    ++episode.false_rows;
    if (!suspect.contains(point.row)) ++episode.unmarked_rows;
  }
}

std::vector<std::string> LieBench::tell_the_truth(int lines) {
  come_to_mid_line();
  const CellTime from = cell_->now();
  const int before = closures();
  for (int line = 1; line <= lines; ++line) {
    if (rows_decided() > (kLines - 4) * kPerLine) come_to_mid_line();
    cell_->until([&] { return closures() >= before + line; });
  }
  std::vector<std::string> found;
  for (const auto& alarm : alarms_since(from)) found.push_back(alarm.kind + ": " + alarm.message);
  return found;
}

}  // namespace driftwise::lies
