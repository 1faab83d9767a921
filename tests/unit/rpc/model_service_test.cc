#include <algorithm>
#include <cmath>

#include "driftwise/v1/model_service.grpc.pb.h"
#include "server/effects/term_order.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/model/model_json.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using ModelStub = v1::ModelService::Stub;

class ModelServiceTest : public RpcTest {
 protected:
  ModelServiceTest() { fakes.models = &models; }
  FakeModels models{cell};
  v1::CreateFitRequest a_fit() {
    v1::CreateFitRequest request;
    request.add_run_ids(1);
    request.set_formula("q ~ x + T");
    return request;
  }
  // A model as it stands in the store, whoever could have made it.
  void keep(const std::string& name, const calibration::Model& model) {
    ASSERT_TRUE(cell.on_store([&](Store& store) {
      ModelRecord record;
      record.name = name;
      record.json = formats::write_model_json(model);
      record.hash = formats::model_hash(model);
      record.created_by = "ada";
      return store.models().add_model(record);
    }));
  }
  template <class Request>
  Request of(std::int64_t id) {
    Request request;
    request.set_model_id(id);
    return request;
  }
};

TEST_F(ModelServiceTest, FitsAndAnswersWithTheStoredModel) {
  auto request = a_fit();
  request.set_p_enter(0.01);
  request.add_exclude_symbols("t01");
  request.set_first_rows(300);
  const auto fit = ask(&ModelStub::CreateFit, request);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_EQ(fit->model().id(), 1);
  EXPECT_EQ(fit->model().formula(), "q ~ x + T");
  const auto asked = cell.on_executor([&] { return models.last_fit; });
  EXPECT_EQ(asked.runs, std::vector<RunId>{RunId{1}});
  EXPECT_DOUBLE_EQ(asked.p_enter, 0.01);
  EXPECT_DOUBLE_EQ(asked.p_remove, 0.10);
  EXPECT_EQ(asked.exclude_channels, std::vector<std::string>{"t01"});
  EXPECT_EQ(asked.first_rows, 300);
}

TEST_F(ModelServiceTest, RefusesAFitThatCannotBeMeant) {
  auto request = a_fit();
  request.clear_run_ids();
  EXPECT_THAT(ask(&ModelStub::CreateFit, request),
              FailsWith(ErrorCode::invalid_argument, "RUNS_OR_CSV"));
  request = a_fit();
  request.set_csv("x_mm\n1\n");
  EXPECT_THAT(ask(&ModelStub::CreateFit, request),
              FailsWith(ErrorCode::invalid_argument, "RUNS_OR_CSV"));
  request = a_fit();
  request.clear_formula();
  EXPECT_THAT(ask(&ModelStub::CreateFit, request),
              FailsWith(ErrorCode::invalid_argument, "EMPTY_FORMULA"));
  request = a_fit();
  request.set_select("best");
  EXPECT_THAT(ask(&ModelStub::CreateFit, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_SELECT"));
  for (const double bad : {0.0, 1.0, -0.1, 2.0, std::nan("")}) {
    request = a_fit();
    request.set_p_enter(bad);
    EXPECT_THAT(ask(&ModelStub::CreateFit, request),
                FailsWith(ErrorCode::invalid_argument, "BAD_PROBABILITY"))
        << bad;
  }
  request = a_fit();
  request.set_p_enter(0.2);
  EXPECT_THAT(ask(&ModelStub::CreateFit, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_PROBABILITY"))
      << "removing sooner than entering goes in circles";
  request = a_fit();
  request.set_first_rows(-1);
  EXPECT_THAT(ask(&ModelStub::CreateFit, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_CURSOR"));
  request = a_fit();
  request.set_formula(std::string(20'000, 'x'));
  EXPECT_THAT(ask(&ModelStub::CreateFit, request),
              FailsWith(ErrorCode::invalid_argument, "TOO_LONG"));
  EXPECT_EQ(ask(&ModelStub::ListModels, {})->models_size(), 0);
}

// A version before this one stored a robot whose scale no robot file may state: the text is as it
// was stored, and does not read back.
TEST_F(ModelServiceTest, ListsAModelThatCannotBeReadAsOneDamagedLine) {
  cell.add_model("q ~ x");
  calibration::Model unreadable;
  unreadable.formula = "linear-axis, identified";
  unreadable.geometry.emplace();
  unreadable.geometry->robot.kind = "linear-axis";
  unreadable.geometry->robot.axes = {
      {.motor = {"q1", "mm"}, .pose = {"x", "mm"}, .scale_ppm = -2000020}};
  keep("reversed", unreadable);
  cell.add_model("q ~ x + T");
  const auto list = ask(&ModelStub::ListModels, {});
  ASSERT_TRUE(list) << list.error().message;
  ASSERT_EQ(list->models_size(), 3);
  EXPECT_EQ(list->models(0).damage(), "");
  EXPECT_EQ(list->models(1).name(), "reversed");
  EXPECT_THAT(list->models(1).damage(), testing::HasSubstr("cannot be read"));
  EXPECT_THAT(list->models(1).damage(), testing::HasSubstr("scale_ppm"));
  EXPECT_EQ(list->models(2).formula(), "q ~ x + T");
  EXPECT_THAT(ask(&ModelStub::GetModel, of<v1::GetModelRequest>(2)),
              FailsWith(ErrorCode::data_loss, "MODEL_DAMAGED"));
}

// An arm as a version before this one identified it on two datums, x of the second 1 mm further on:
// its geometry stands half way, and its robot file is that of the first.
TEST_F(ModelServiceTest, WritesTheRobotFileOfAnArmInItsFirstDatum) {
  calibration::Model model;
  model.formula = "serial-arm, identified";
  model.geometry.emplace();
  auto& robot = model.geometry->robot;
  robot.kind = "serial-arm";
  robot.links = {{.motor = {"q1", "deg"}, .d_mm = 300, .alpha_deg = 90},
                 {.motor = {"q2", "deg"}, .a_mm = 500},
                 {.motor = {"q3", "deg"}, .a_mm = 400}};
  robot.frame = {.x_mm = 900.5, .y_mm = -400};
  for (const char* axis : {"x", "y", "z"}) {
    auto& output = model.outputs.emplace_back();
    output.channel = {axis, "mm"};
    output.terms = {effects::Term{}, effects::datum_term(2)};
    output.coefficients = output.channel.symbol == "x" ? Eigen::Vector2d(-0.5, 1)
                                                       : Eigen::Vector2d(Eigen::Vector2d::Zero());
    output.covariance = Eigen::Matrix2d::Zero();
  }
  keep("both", model);
  const auto shown = ask(&ModelStub::GetModel, of<v1::GetModelRequest>(1));
  ASSERT_TRUE(shown) << shown.error().message;
  const auto file =
      formats::parse_robot_file(shown->model().kinematics().robot_toml(), "robot.toml");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_DOUBLE_EQ(file->frame.x_mm, 900);
  EXPECT_DOUBLE_EQ(file->frame.y_mm, -400);
}

TEST_F(ModelServiceTest, GivesFiguresInTheSummaryUnitAndCoefficientsInTheColumns) {
  ASSERT_TRUE(ask(&ModelStub::CreateFit, a_fit()));
  const auto response = ask(&ModelStub::GetModel, of<v1::GetModelRequest>(1));
  ASSERT_TRUE(response);
  const auto& output = response->model().outputs(0);
  EXPECT_EQ(output.unit(), "mm");
  EXPECT_EQ(output.summary_unit(), "nm");
  EXPECT_NEAR(output.accuracy().u90_calibration(), 8.2, 1e-9);
  EXPECT_FALSE(output.accuracy().has_u90_blocks());
  EXPECT_NEAR(output.accuracy().a90_validation(), 9.7, 1e-9);
  ASSERT_EQ(output.terms_size(), 3);
  EXPECT_EQ(output.terms(1).term(), "x");
  EXPECT_DOUBLE_EQ(output.terms(1).coefficient(), 1.0);
  EXPECT_NEAR(output.terms(1).contribution_rms(), 2.3e6, 1e-6);
  EXPECT_FALSE(output.terms(2).included());
  EXPECT_FALSE(output.terms(2).has_vif());
  EXPECT_EQ(response->model().fit_duration().nanos(), 48'100);
}

TEST_F(ModelServiceTest, AnswersAFormulaWithATypoWithTheProblemAndItsPlace) {
  cell.on_executor([&] {
    models.formula_check.problem = "formula: unknown channel 'to7'";
    models.formula_check.problem_offset = 8;
    models.formula_check.channels = {{"x", "mm"}, {"t07", "degC"}};
  });
  v1::CheckFormulaRequest request;
  *request.mutable_fit() = a_fit();
  const auto check = ask(&ModelStub::CheckFormula, request);
  ASSERT_TRUE(check) << check.error().message;
  EXPECT_EQ(check->problem(), "formula: unknown channel 'to7'");
  EXPECT_EQ(check->problem_offset(), 8);
  ASSERT_EQ(check->channels_size(), 2);
  EXPECT_EQ(check->channels(1).symbol(), "t07");
  EXPECT_TRUE(std::ranges::any_of(check->effects(), [](const auto& effect) {
    return effect.name() == "lag" && effect.cause() == "thermal_lag";
  })) << "a field that completes needs to know the effects";
}

TEST_F(ModelServiceTest, ListsResidualsWithTheChannelsTheyMayGoWith) {
  ASSERT_TRUE(ask(&ModelStub::CreateFit, a_fit()));
  cell.on_executor([&] {
    auto& data = models.the_residuals.data;
    data.rows = 3;
    data.time_s = {0, 10, 20};
    data.set = {PointSet::calibration, PointSet::validation, PointSet::calibration};
    data.columns = {{{"t07", "degC"}, {20.5, 20.6, kMissing}}};
    models.the_residuals.outputs = {{{"q1", "mm"}, {1.5, -2.5, 0.5}, {}}};
  });
  const auto rows = ask(&ModelStub::ListResiduals, of<v1::ListResidualsRequest>(1));
  ASSERT_TRUE(rows) << rows.error().message;
  EXPECT_EQ(rows->time_s_size(), 3);
  EXPECT_TRUE(rows->validation(1));
  EXPECT_FALSE(rows->excluded(1));
  EXPECT_EQ(rows->row_step(), 1);
  ASSERT_EQ(rows->outputs_size(), 1);
  EXPECT_EQ(rows->outputs(0).unit(), "nm");
  EXPECT_DOUBLE_EQ(rows->outputs(0).values(1), -2.5);
  EXPECT_TRUE(std::isnan(rows->variables(0).values(2)));
}

TEST_F(ModelServiceTest, PromotesOneAndRollsBackToNone) {
  ASSERT_TRUE(ask(&ModelStub::CreateFit, a_fit()));
  auto promoted = of<v1::PromoteModelRequest>(1);
  EXPECT_THAT(ask(&ModelStub::PromoteModel, promoted),
              FailsWith(ErrorCode::failed_precondition, "NEEDS_CONFIRMATION"))
      << "no run of this cell made it";
  promoted.set_confirmed(true);
  promoted.set_reason(std::string(17 * 1024, 'x'));
  EXPECT_THAT(ask(&ModelStub::PromoteModel, promoted),
              FailsWith(ErrorCode::invalid_argument, "TOO_LONG"));
  promoted.clear_reason();
  EXPECT_TRUE(ask(&ModelStub::PromoteModel, promoted)->model().serving());
  EXPECT_TRUE(ask(&ModelStub::ListModels, v1::ListModelsRequest{})->models(0).serving());
  EXPECT_EQ(ask(&ModelStub::ListModels, v1::ListModelsRequest{})->models(0).outputs(0).terms_size(),
            0)
      << "a list is short";
  EXPECT_FALSE(ask(&ModelStub::RollBackModel, v1::RollBackModelRequest{})->has_model());
  const auto history = ask(&ModelStub::ListPromotions, v1::ListPromotionsRequest{});
  ASSERT_EQ(history->promotions_size(), 2);
  EXPECT_EQ(history->promotions(1).action(), v1::Promotion::ACTION_ROLLBACK);
  EXPECT_FALSE(history->promotions(1).has_model_id());
  EXPECT_THAT(ask(&ModelStub::PromoteModel, of<v1::PromoteModelRequest>(5)),
              FailsWith(ErrorCode::not_found, "NO_SUCH_MODEL"));
  EXPECT_THAT(ask(&ModelStub::PromoteModel, of<v1::PromoteModelRequest>(-5)),
              FailsWith(ErrorCode::invalid_argument, "BAD_ID"));
}

TEST_F(ModelServiceTest, PromotesNothingOverAModelThatTheCallerDidNotSeeServe) {
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(ask(&ModelStub::CreateFit, a_fit()));
  const auto promotion = [this](std::int64_t model, std::int64_t seen) {
    auto request = of<v1::PromoteModelRequest>(model);
    request.set_confirmed(true);
    request.set_serving_model_id(seen);
    return request;
  };
  EXPECT_TRUE(ask(&ModelStub::PromoteModel, promotion(2, 0))) << "none was seen, and none serves";
  const auto stale = ask(&ModelStub::PromoteModel, promotion(1, 0));
  EXPECT_THAT(stale, FailsWith(ErrorCode::failed_precondition, "STALE"));
  EXPECT_THAT(stale.error().message,
              testing::HasSubstr("model 2 serves by now, where no model was seen to serve"));
  EXPECT_TRUE(ask(&ModelStub::PromoteModel, promotion(3, 2)));
  EXPECT_THAT(ask(&ModelStub::PromoteModel, promotion(1, 2)),
              FailsWith(ErrorCode::failed_precondition, "STALE"));
  EXPECT_TRUE(ask(&ModelStub::PromoteModel, promotion(3, 2))) << "it serves already, as wanted";
  EXPECT_EQ(ask(&ModelStub::ListPromotions, v1::ListPromotionsRequest{})->promotions_size(), 2);
  EXPECT_THAT(ask(&ModelStub::PromoteModel, promotion(1, -1)),
              FailsWith(ErrorCode::invalid_argument, "BAD_ID"));
}

TEST_F(ModelServiceTest, ComparesTermByTerm) {
  ASSERT_TRUE(ask(&ModelStub::CreateFit, a_fit()));
  ASSERT_TRUE(ask(&ModelStub::CreateFit, a_fit()));
  v1::CompareModelsRequest request;
  request.add_model_ids(2);
  EXPECT_THAT(ask(&ModelStub::CompareModels, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_MODEL_COUNT"));
  request.add_model_ids(1);
  const auto comparison = ask(&ModelStub::CompareModels, request);
  ASSERT_TRUE(comparison);
  EXPECT_EQ(comparison->models(0).id(), 2);
  ASSERT_EQ(comparison->rows_size(), 3);
  EXPECT_EQ(comparison->rows(2).term(), "t07");
  ASSERT_EQ(comparison->rows(2).cells_size(), 2);
  EXPECT_TRUE(comparison->rows(2).cells(0).offered());
  EXPECT_FALSE(comparison->rows(2).cells(0).included());
}

TEST_F(ModelServiceTest, ExportsAsJsonAndAsC) {
  ASSERT_TRUE(ask(&ModelStub::CreateFit, a_fit()));
  auto request = of<v1::ExportModelRequest>(1);
  EXPECT_THAT(ask(&ModelStub::ExportModel, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_FORMAT"));
  request.set_format(v1::ExportModelRequest::FORMAT_JSON);
  EXPECT_THAT(ask(&ModelStub::ExportModel, request)->text(),
              testing::HasSubstr("driftwise.model.v1"));
  request.set_format(v1::ExportModelRequest::FORMAT_C);
  const auto c = ask(&ModelStub::ExportModel, request);
  ASSERT_TRUE(c) << c.error().message;
  EXPECT_EQ(c->file_name(), "model_1.c");
  EXPECT_THAT(c->text(), testing::HasSubstr("driftwise_model_1"));
}

TEST_F(ModelServiceTest, SaysWhenAStoredModelIsDamaged) {
  cell.on_store([](Store& store) {
    ModelRecord damaged;
    damaged.json = "{";
    damaged.hash = "0123";
    damaged.created = kWorldBegin;
    ASSERT_TRUE(store.models().add_model(damaged));
  });
  EXPECT_THAT(ask(&ModelStub::GetModel, of<v1::GetModelRequest>(1)),
              FailsWith(ErrorCode::data_loss, "MODEL_DAMAGED"));
}

}  // namespace
}  // namespace driftwise::tests
