#include "clients/cli/commands/indentation/wire_cell.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "clients/cli/commands/indentation/indent_checks.h"
#include "clients/cli/core/text.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::cli {
namespace {

constexpr double kMoveLimit_s = 600;
constexpr auto kReadingLimit = std::chrono::seconds(60);  // wall: then the stream is taken as dead

}  // namespace

WireCell::WireCell(const Connection& connection, const formats::IndentationFile& file,
                   v1::HoldAnswer answer)
    : connection_(connection.uninterrupted()),
      asked_(connection),
      file_(file),
      answer_(std::move(answer)),
      lease_(connection_, ""),
      motors_(connection_, file) {
  const auto status = connection_.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{});
  speed_ = std::max(status.speed(), 1e-3);
  thread_ = std::thread([this] { follow(); });
}

WireCell::~WireCell() {
  stream_.TryCancel();
  thread_.join();
}

// Ends with the stream, also where no reading comes any more: the lease is given up after it.
void WireCell::follow() {
  std::string why = "the daemon ended the stream of readings";
  try {
    connection_.follow(stream_, &v1::CellService::Stub::WatchReadings, v1::WatchReadingsRequest{},
                       [this](const v1::WatchReadingsResponse& response) {
                         const std::lock_guard lock(mutex_);
                         for (const auto& value : response.reading().values()) {
                           if (!value.has_value()) continue;
                           auto& channel = latest_[value.channel()];
                           channel.value = value.value();
                           ++channel.count;
                         }
                         last_ = response.reading().end_time();
                         arrived_.notify_all();
                         return true;
                       });
  } catch (const Failure& failure) {
    why = failure.message;
  }
  const std::lock_guard lock(mutex_);
  lost_ = why;
  arrived_.notify_all();
}

Result<void> WireCell::interrupted() const {
  if (!asked_.interrupted()) return {};
  return fail(ErrorCode::cancelled, reasons::kCancelled,
              "interrupted; `driftwise indent start` with the same file goes on");
}

Result<void> WireCell::move(const Motors& motors) {
  v1::MoveRequest request;
  request.set_lease_token(lease_.token());
  *request.mutable_answer() = answer_;
  for (const auto& [channel, value_mm] : motors) {
    auto* one = request.add_coordinates();
    one->set_channel(channel);
    one->set_value(value_mm);
  }
  try {
    connection_.ask(&v1::CellService::Stub::Move, request, kMoveLimit_s);
  } catch (const Failure& failure) {
    return tl::unexpected(error_of(failure));
  }
  for (const auto& [channel, value_mm] : motors) commanded_[channel] = value_mm;
  return {};
}

Result<WireCell::Answer> WireCell::move_above(double x_mm, double y_mm, double z_mm) {
  DRIFTWISE_RETURN_IF_ERROR(interrupted());
  wanted_.x_mm = x_mm;
  wanted_.y_mm = y_mm;
  wanted_.z_mm = z_mm;
  DRIFTWISE_TRY(const auto found, motors_.of(file_.above, wanted_));
  DRIFTWISE_RETURN_IF_ERROR(move(found));
  return Answer{motors_.by(), motors_.source()};
}

Result<WireCell::Answer> WireCell::move_below(double rx_arcsec, double ry_arcsec,
                                              double height_mm) {
  wanted_.rx_arcsec = rx_arcsec;
  wanted_.ry_arcsec = ry_arcsec;
  wanted_.height_mm = height_mm;
  DRIFTWISE_TRY(const auto found, motors_.of(file_.below, wanted_));
  DRIFTWISE_RETURN_IF_ERROR(move(found));
  return Answer{motors_.by(), motors_.source()};
}

Result<WireCell::Answer> WireCell::retract_below(double rx_arcsec, double ry_arcsec,
                                                 double height_mm) {
  wanted_.rx_arcsec = rx_arcsec;
  wanted_.ry_arcsec = ry_arcsec;
  wanted_.height_mm = height_mm;
  DRIFTWISE_TRY(auto found, motors_.of(file_.below, wanted_));
  DRIFTWISE_TRY(const auto present_mm, present(found));
  bool is_higher = false;
  for (auto& [channel, value_mm] : found) {
    is_higher = is_higher || present_mm.at(channel) > value_mm;
    value_mm = std::min(value_mm, present_mm.at(channel));
  }
  if (is_higher) DRIFTWISE_RETURN_IF_ERROR(move(found));
  return Answer{motors_.by(), motors_.source()};
}

// Positions of these axes by read-back: at once after an interrupt, else by the next reading.
// During a run in a set-up of the other robot nobody reads them.
Result<Motors> WireCell::present(const Motors& of) {
  std::vector<std::string> channels;
  for (const auto& [channel, wanted_mm] : of) channels.push_back(channel);
  DRIFTWISE_TRY(const auto values, collect(channels, 1));
  Motors present_mm;
  for (std::size_t i = 0; i < channels.size(); ++i)
    present_mm[channels[i]] = values(0, static_cast<Eigen::Index>(i));
  return present_mm;
}

Result<void> WireCell::nudge_above(double dx_mm, double dy_mm) {
  return move_above(wanted_.x_mm + dx_mm, wanted_.y_mm + dy_mm, wanted_.z_mm)
      .map([](const Answer&) {});
}

Result<Eigen::MatrixXd> WireCell::collect(const std::vector<std::string>& channels, int readings) {
  Eigen::MatrixXd values(readings, static_cast<Eigen::Index>(channels.size()));
  std::unique_lock lock(mutex_);
  // The next one may have been begun before the call.
  std::vector<std::int64_t> seen;
  for (const auto& channel : channels) seen.push_back(latest_[channel].count + 1);
  for (int k = 0; k < readings; ++k) {
    for (std::size_t i = 0; i < channels.size(); ++i) {
      auto& channel = latest_[channels[i]];
      const bool there = arrived_.wait_for(lock, kReadingLimit, [&] {
        return channel.count > seen[i] || !lost_.empty() || asked_.interrupted();
      });
      if (!lost_.empty())
        return fail(ErrorCode::unavailable, reasons::kLinkLost,
                    "no more readings: " + lost_ +
                        ". The robots hold where they are; start again with the same file");
      if (!there || channel.count == 0)
        return fail(ErrorCode::failed_precondition, reasons::kNoChannel,
                    "no reading of " + channels[i] + " within " +
                        std::to_string(kReadingLimit.count()) +
                        " s: is it a channel of this cell, and is its device connected?");
      seen[i] = channel.count;
      values(k, static_cast<Eigen::Index>(i)) = channel.value;
    }
  }
  return values;
}

Result<Eigen::MatrixXd> WireCell::look() {
  DRIFTWISE_RETURN_IF_ERROR(interrupted());
  std::vector<std::string> channels;
  for (int i = 1; i <= 3; ++i) channels.push_back(file_.above + ".q" + std::to_string(i) + "_mm");
  // Begun by an earlier client: its robot stays where it was told to be.
  if (!commanded_.contains(channels.front())) {
    DRIFTWISE_TRY(const auto at_rest, collect(channels, file_.readings));
    for (std::size_t i = 0; i < channels.size(); ++i)
      commanded_[channels[i]] = at_rest.col(static_cast<Eigen::Index>(i)).mean();
  }
  DRIFTWISE_TRY(Eigen::MatrixXd window, collect(channels, file_.readings));
  for (std::size_t i = 0; i < channels.size(); ++i) {
    auto column = window.col(static_cast<Eigen::Index>(i));
    column = (commanded_.at(channels[i]) - column.array()) * kNmPerMm;
  }
  DRIFTWISE_RETURN_IF_ERROR(interrupted());
  return window;
}

Result<void> WireCell::wait(double cell_s) {
  DRIFTWISE_RETURN_IF_ERROR(interrupted());
  std::this_thread::sleep_for(std::chrono::duration<double>(cell_s / speed_));
  return {};
}

std::string WireCell::utc() {
  const std::lock_guard lock(mutex_);
  return iso_text(last_);
}

std::string WireCell::live_channel(const std::string& coordinate) {
  const std::lock_guard lock(mutex_);
  for (const auto& name : live_names(coordinate))
    if (latest_.contains(name)) return name;
  return coordinate;
}

Result<WireCell::Here> WireCell::here() {
  DRIFTWISE_RETURN_IF_ERROR(interrupted());
  std::vector<std::string> channels;
  // Only differences count: rotations as the device gives them serve as well as those since a
  // datum. Lengths are paths, with [correction] and without it.
  for (const char* name : {".x_mm", ".y_mm", ".z_mm", ".rx_arcsec", ".ry_arcsec"})
    channels.push_back(live_channel(file_.above + name));
  DRIFTWISE_TRY(const auto values, collect(channels, file_.poses));
  const Eigen::RowVectorXd mean = values.colwise().mean();
  Here here{.x_mm = mean[0],
            .y_mm = mean[1],
            .z_mm = mean[2],
            .rx_arcsec = mean[3],
            .ry_arcsec = mean[4]};
  for (const auto& [channel, value_mm] : commanded_) here.motors_mm.emplace_back(channel, value_mm);
  try {
    const auto status = connection_.ask(&v1::CellService::Stub::GetStatus, v1::GetStatusRequest{});
    for (const auto& name : file_.temperatures) {
      const auto found = std::ranges::find(status.values(), name, &v1::LatestValue::channel);
      if (found == status.values().end() || !found->has_value() || found->stale())
        return fail(ErrorCode::failed_precondition, reasons::kChannelMissing,
                    "temperature " + name +
                        " has no fresh value: is it a channel of this cell, and does its scanner "
                        "answer?");
      here.degc.emplace_back(name, found->value());
    }
  } catch (const Failure& failure) {
    return tl::unexpected(error_of(failure));
  }
  return here;
}

}  // namespace driftwise::cli
