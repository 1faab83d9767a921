#include "tests/statistics/two_datums_case.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/core/units.h"
#include "tests/statistics/micro_nano_case.h"

namespace driftwise::statistics {
namespace {

using testing_support::MicroNanoRow;
using testing_support::MicroNanoSession;

constexpr CellTime kDatumsEpoch{1'600'000'000'000'000'000};
constexpr double kFirstRoom_degc = 19;
constexpr int kSteps = 6, kJudged = 100;

std::vector<ChannelValue> conditions_of(const MicroNanoRow& row) {
  std::vector<ChannelValue> values;
  for (std::size_t i = 0; i < row.t_degc.size(); ++i)
    values.push_back({(i < 9 ? "t0" : "t") + std::to_string(i + 1) + "_degC", row.t_degc[i]});
  return values;
}

DatumZero zero_of(const MicroNanoRow& row, const DatumZero& before) {
  DatumZero zero{conditions_of(row), before.true_pose_mm};
  for (std::size_t k = 0; k < 3; ++k) {
    zero.values.push_back({"q" + std::to_string(k + 1) + "_mm", row.q_mm[k]});
    zero.true_pose_mm[k] += row.true_mm[k];
  }
  zero.values.push_back({"force_N", row.force_n});
  return zero;
}

void measure_grid(MicroNanoSession& session, double force_n, std::vector<MicroNanoRow>& rows) {
  session.load(force_n);
  for (int line = 0; line < kSteps * kSteps; ++line)
    for (int k = 0; k <= kSteps; ++k) {
      const bool zero = k == kSteps;
      auto row =
          session.visit(zero ? std::array{0.0, 0.0, 0.0}
                             : std::array{0.5 * (line / kSteps), 0.5 * (line % kSteps), 0.5 * k});
      row.calibration = true;
      row.zero = zero;
      row.line = line;
      rows.push_back(row);
    }
}

}  // namespace

const char* const kTwoDatumsFormula =
    "q ~ poly(x, y, z, 3) + F + F^2 + F^3 + t04..t10 + (F + t04):poly(x, y, z, 2)";

TwoDatums two_datums_case(std::uint64_t seed, const TwoDatumsOptions& options) {
  testing_support::MicroNanoOptions plant;
  plant.seed = seed;
  plant.coarse = options.coarse;
  plant.overrides = {"room.balance_degc=" + std::to_string(kFirstRoom_degc + options.room_k)};
  MicroNanoSession session(DRIFTWISE_SOURCE_DIR, plant);
  TwoDatums made;
  made.cell = micro_nano_cell();
  std::vector<MicroNanoRow> rows;
  made.zeros[0] = zero_of(session.zero(), {});
  made.zeros[0].true_pose_mm = {};
  for (const double force_n : {0.0, 2.305}) measure_grid(session, force_n, rows);
  const std::size_t first = rows.size();
  session.load(0);
  session.wait(3600 * options.pause_h);
  made.zeros[1] = zero_of(session.zero(), made.zeros[0]);
  for (const double force_n : {0.0, 1.536}) measure_grid(session, force_n, rows);
  session.load(0);
  session.wait(3600 * options.pause_h);
  made.zeros[2] = zero_of(session.zero(), made.zeros[1]);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> inside(0.0, 2.5);
  for (const double force_n : {0.0, 0.768, 1.9}) {
    session.load(force_n);
    for (int i = 0; i < kJudged / 3; ++i)
      made.judged.push_back(session.visit({inside(random), inside(random), inside(random)}));
  }
  made.data = micro_nano_dataset(rows, made.cell);
  made.data.datum.assign(made.data.rows, 1);
  for (std::size_t i = first; i < made.data.rows; ++i) made.data.datum[i] = 2;
  return made;
}

Dataset only_datum(const Dataset& data, std::int64_t datum) {
  Dataset only = data;
  for (std::size_t i = 0; i < data.rows; ++i)
    if (data.datum[i] != datum) {
      only.excluded.resize(data.rows);
      only.excluded[i] = 1;
    }
  return only;
}

Dataset at_true_zeros(const TwoDatums& made) {
  Dataset moved = made.data;
  for (auto& column : moved.columns)
    for (std::size_t k = 0; k < 3; ++k)
      if (column.channel.symbol == std::string(1, "xyz"[k]))
        for (std::size_t i = 0; i < moved.rows; ++i)
          column.values[i] +=
              made.zeros[static_cast<std::size_t>(moved.datum[i] - 1)].true_pose_mm[k];
  return moved;
}

diagnosis::RunToCheck third_datum_run(const TwoDatums& made) {
  return {RunId{3}, micro_nano_dataset(made.judged, made.cell), {made.zeros[2].values}};
}

std::array<double, 3> u90_in_third_datum(const calibration::Model& model, const TwoDatums& made) {
  auto builder = compensation::SnapshotBuilder::create(model, ModelId{1}, made.cell);
  if (!builder) throw std::runtime_error(builder.error().message);
  builder->observe(made.zeros[2].values, kDatumsEpoch);
  if (auto ok = builder->anchor(made.zeros[2].values); !ok)
    throw std::runtime_error(ok.error().message);
  std::array<double, 3> squares{};
  for (const auto& row : made.judged) {
    const CellTime at = kDatumsEpoch + nanoseconds_from_s(row.time_s);
    builder->observe(conditions_of(row), at);
    compensation::TargetRequest asked;
    for (std::size_t k = 0; k < 3; ++k)
      asked.set(static_cast<compensation::Variable>(k), row.true_mm[k]);
    asked.set(compensation::Variable::force, row.force_n);
    const auto snapshot = builder->build(at);
    const auto target = compensation::compute_target(snapshot, asked);
    if (target.refusal != compensation::Refusal::none)
      throw std::runtime_error(compensation::refusal_error(snapshot, target).message);
    for (std::size_t k = 0; k < 3; ++k)
      squares[k] += std::pow(nm_from_mm(target.q_mm[k] - row.q_mm[k]), 2);
  }
  std::array<double, 3> u90{};
  for (std::size_t k = 0; k < 3; ++k)
    u90[k] = kSigmaToU90 * std::sqrt(squares[k] / static_cast<double>(made.judged.size()));
  return u90;
}

}  // namespace driftwise::statistics
