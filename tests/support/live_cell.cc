#include "tests/support/live_cell.h"

#include "server/formats/model/model_json.h"
#include "storage/sqlite_store.h"

namespace driftwise::tests {
namespace {

calibration::TermReport report(const effects::Term& term, bool in, double coefficient,
                               double contribution_rms) {
  calibration::TermReport out;
  out.term = term;
  out.in = in;
  out.coefficient = coefficient;
  out.standard_error = 1e-7;
  out.t = coefficient / out.standard_error;
  out.p = in ? 1e-20 : 0.62;
  out.vif = in ? 1.2 : 0;
  out.contribution_rms = contribution_rms;
  out.contribution_max = 2 * contribution_rms;
  return out;
}

calibration::Model small_model(const std::string& formula) {
  using namespace calibration;
  Model model;
  model.formula = formula;
  OutputModel output;
  output.channel = {"q1", "mm"};
  const effects::Term constant, x{{effects::Power{"x", 1}}}, t07{{effects::Power{"t07", 1}}};
  output.terms = {constant, x};
  output.coefficients = Eigen::Vector2d(1e-6, 1.0);
  output.covariance = Eigen::Matrix2d::Identity() * 1e-14;
  output.dof = 558;
  output.accuracy.rmse = 5e-6;
  output.accuracy.u90_calibration = 8.2e-6;
  output.accuracy.a90_calibration = 8.2e-6;
  output.accuracy.u90_validation = 9.1e-6;
  output.accuracy.mean_validation = 2e-6;
  output.accuracy.a90_validation = 9.7e-6;
  output.report = {report(constant, true, 1e-6, 0), report(x, true, 1.0, 2.3),
                   report(t07, false, 1e-7, 1.1e-8)};
  output.history = {{1, "enter", x, 0.0, 5e-6, 558}};
  model.outputs = {output};
  model.domain = {{{"x", "mm"}, -4, 4}};
  model.lineage.source = "runs 1";
  model.lineage.dataset_hash = "abc";
  model.lineage.rows_calibration = 560;
  model.lineage.rows_validation = 448;
  model.fit_us = 48.1;
  return model;
}

template <class T>
T good(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

}  // namespace

LiveCell::LiveCell(app::Diagnose diagnose) {
  const OpenStore open = [this](const std::string& path, bool read_only) {
    auto store = storage::open_sqlite_store(path, read_only);
    if (store && !read_only) store_ = store->get();
    return store;
  };
  cell_ = std::make_unique<CellInMemory>(world, small_cell(folder_ / "cell.sqlite"), open,
                                         CellInMemory::Further{.diagnose = std::move(diagnose)});
  // Every device has been asked, and every thermometer has a value.
  cell_->until([this] {
    const auto status = cell_->status();
    return std::ranges::all_of(
               status.devices,
               [](const auto& one) { return one.health.link == LinkState::connected; }) &&
           std::ranges::any_of(status.values, [](const auto& one) {
             return one.channel.symbol == "t01" && one.at.utc_ns != 0;
           });
  });
  cell_->pass(1);  // what the start has to say is on record
  thread_ = std::thread([this] { run(); });
}

LiveCell::~LiveCell() {
  post([this] { ending_ = true; });
  thread_.join();
}

void LiveCell::post(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push(std::move(job));
  }
  asio::post(cell_->io(), [] {});  // the thread looks
}

void LiveCell::run() {
  const auto work = asio::make_work_guard(cell_->io());
  while (!ending_) {
    std::function<void()> job;
    {
      const std::lock_guard lock(mutex_);
      if (!jobs_.empty()) {
        job = std::move(jobs_.front());
        jobs_.pop();
      }
    }
    if (job) {
      job();
      continue;
    }
    cell_->io().restart();
    const auto patience = std::chrono::milliseconds(passing_ > 0 ? 1 : 1000);
    if (cell_->io().run_one_for(patience) == 0 && passing_ > 0) cell_->time().step();
  }
  cell_->shut_down();
}

std::shared_ptr<void> LiveCell::passing() {
  ++passing_;
  on_executor([] {});
  return std::shared_ptr<void>(this, [](void* cell) { --static_cast<LiveCell*>(cell)->passing_; });
}

app::Services LiveCell::services(const Fakes& fakes) {
  const app::Services& own = **cell_;
  return {own.host,
          own.overview,
          own.records,
          own.manual,
          fakes.runs ? *fakes.runs : own.runs,
          own.trajectories,
          fakes.datasets ? *fakes.datasets : own.datasets,
          own.annotations,
          fakes.models ? *fakes.models : own.models,
          own.promotions,
          fakes.checks ? *fakes.checks : own.checks,
          fakes.targets ? *fakes.targets : own.targets,
          own.provenance,
          fakes.configurations ? *fakes.configurations : own.configurations,
          fakes.diagnoses ? *fakes.diagnoses : own.diagnoses,
          fakes.extensions ? *fakes.extensions : own.extensions,
          fakes.improvements ? *fakes.improvements : own.improvements,
          fakes.studies ? *fakes.studies : own.studies,
          fakes.alarms ? *fakes.alarms : own.alarms,
          fakes.feeds ? *fakes.feeds : own.feeds,
          own.queue,
          own.keeping,
          own.holds,
          own.notifications,
          own.plans,
          own.joint_targets,
          own.jogs,
          own.commissioning,
          own.look_back,
          own.support,
          own.reports,
          own.indentations};
}

EventId LiveCell::add_event(const std::string& what) {
  return on_executor([&] {
    EventRecord event;
    event.at = {cell_->now(), 0};
    event.who = "daemon";
    event.what = what;
    return good(store_->events().add_event(event));
  });
}

std::optional<EventRecord> LiveCell::last_event(const std::string& what) {
  std::optional<EventRecord> last;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!last && std::chrono::steady_clock::now() < until)
    on_store([&](Store& store) {
      for (auto& event : good(store.events().events(EventId{0}, 100'000)))
        if (event.what == what) last = std::move(event);
    });
  return last;
}

RunId LiveCell::add_run(const std::string& name) {
  return on_executor([&] {
    NewRun run;
    run.name = run.trajectory_name = name;
    run.trajectory_text = "x_mm\n0\n1\n0\n";
    run.rows = 100;
    run.rules_json = "{}";
    run.operator_name = "ada";
    run.config_hash = "c0ffee";
    run.created = {cell_->now(), 0};
    return good(store_->runs().create_run(run)).id;
  });
}

DatumId LiveCell::add_datum(RunId run) {
  return on_executor([&] {
    DatumRecord datum;
    datum.run = run;
    datum.opened = {cell_->now(), 0};
    datum.reason = "start";
    return good(store_->points().open_datum(datum));
  });
}

void LiveCell::add_points(RunId run, std::vector<PointRecord> points) {
  const DatumId datum = add_datum(run);
  on_executor([&] {
    auto row = good(store_->runs().run(run)).accepted;
    for (auto& point : points) {
      point.run = run;
      point.row = row++;
      point.datum = datum;
      point.measured = {cell_->now(), row};
      PointCommit commit;
      commit.run = run;
      AttemptRecord attempt;
      attempt.row = point.row;
      attempt.started = attempt.ended = point.measured;
      commit.attempts = {attempt};
      commit.point = std::move(point);
      commit.place.next_row = row;
      good(store_->points().commit(commit));
    }
  });
}

ModelId LiveCell::put_model(const std::string& formula) {
  auto model = small_model(formula);  // of a dataset of its own: the same fit is the same model
  model.lineage.dataset_hash = std::to_string(good(store_->models().models()).size());
  ModelRecord record;
  record.name = "first";
  record.json = formats::write_model_json(model);
  record.hash = good(formats::stored_model_hash(record.json));
  record.created = cell_->now();
  record.created_by = "ada";
  return good(store_->models().add_model(record));
}

}  // namespace driftwise::tests
