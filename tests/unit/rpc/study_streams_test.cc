// Comparisons of methods and choices of thermometers as streams: progress, then the answer; who
// leaves ends the work.

#include "driftwise/v1/model_service.grpc.pb.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

class StudyStreamsTest : public RpcTest {
 protected:
  StudyStreamsTest() { fakes.studies = &studies; }
  FakeStudies studies;
  static v1::CompareMethodsRequest comparison() {
    v1::CompareMethodsRequest request;
    request.mutable_fit()->add_run_ids(3);
    request.mutable_fit()->set_formula("q ~ x + T");
    request.mutable_fit()->set_thread_count(2);
    request.add_methods("classic");
    request.set_together("line");
    return request;
  }
  // All messages of a stream, and how it ended.
  template <class Response, class Reader>
  static std::pair<std::vector<Response>, Result<void>> all_of(Reader& reader) {
    std::vector<Response> messages;
    Response response;
    while (reader.Read(&response)) messages.push_back(response);
    const grpc::Status status = reader.Finish();
    if (status.ok()) return {messages, {}};
    return {messages, tl::unexpected(rpc::to_error(status))};
  }
  template <class Response>
  std::pair<std::vector<Response>, Result<void>> compared(
      const v1::CompareMethodsRequest& request) {
    Call call;
    const auto reader = v1::ModelService::Stub(channel).CompareMethods(&call, request);
    return all_of<Response>(*reader);
  }
  auto sensors(const v1::StudySensorsRequest& request) {
    Call call;
    const auto reader = v1::ModelService::Stub(channel).StudySensors(&call, request);
    return all_of<v1::StudySensorsResponse>(*reader);
  }
};

identification::Judgement judgement() {
  identification::Judgement one;
  one.fitted.method = identification::Method::classic;
  one.fitted.outputs = {{"q1", "mm"}};
  one.fitted.fit_us = 1500;
  identification::OutputFigures figures;
  figures.channel = {"q1", "mm"};
  figures.u90_calibration = 41e-6;
  figures.u90_validation = 52e-6;
  one.outputs = {figures};
  one.rows_calibration = 80;
  return one;
}

TEST_F(StudyStreamsTest, AComparisonTellsItsProgressThenItsAnswer) {
  cell.on_executor([&] { studies.judgements = {judgement()}; });
  const auto [messages, end] = compared<v1::CompareMethodsResponse>(comparison());
  ASSERT_TRUE(end) << end.error().message;
  const auto& answer = messages.back();
  EXPECT_FALSE(answer.has_progress());
  ASSERT_EQ(answer.methods_size(), 1);
  EXPECT_EQ(answer.methods(0).method(), "classic");
  EXPECT_EQ(answer.methods(0).outputs(0).unit(), "nm");
  EXPECT_DOUBLE_EQ(answer.methods(0).outputs(0).u90_calibration(), 41);
  EXPECT_FALSE(answer.methods(0).outputs(0).has_u90_blocks());
  EXPECT_EQ(answer.methods(0).fit_duration().nanos(), 1'500'000);
  EXPECT_THAT(answer.json(), testing::HasSubstr("driftwise.comparison.v1"));
  EXPECT_THAT(answer.table(), testing::HasSubstr("classic"));
  for (std::size_t i = 0; i + 1 < messages.size(); ++i) EXPECT_TRUE(messages[i].has_progress());
  const auto asked = cell.on_executor([&] { return studies.last_methods; });
  EXPECT_EQ(asked.fit.runs, std::vector{RunId{3}});
  EXPECT_EQ(asked.fit.threads, 2);
  EXPECT_EQ(asked.methods, std::vector<std::string>{"classic"});
  EXPECT_EQ(asked.together, "line");
}

TEST_F(StudyStreamsTest, WhoLeavesEndsTheWork) {
  cell.on_executor([&] { studies.waits = true; });
  Call call;
  const auto reader = v1::ModelService::Stub(channel).CompareMethods(&call, comparison());
  v1::CompareMethodsResponse first;
  ASSERT_TRUE(reader->Read(&first));
  EXPECT_EQ(first.progress().step(), "looking");
  call.TryCancel();
  reader->Finish();
  EXPECT_TRUE(eventually([&] { return studies.last->stopped(); }));
}

TEST_F(StudyStreamsTest, AFailureEndsTheStreamWithItsReason) {
  cell.on_executor([&] {
    studies.fail_next =
        Error{ErrorCode::invalid_argument, "OTHER_OUTPUTS", "the left side differs"};
  });
  const auto [messages, end] = compared<v1::CompareMethodsResponse>(comparison());
  EXPECT_TRUE(messages.empty());
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().reason, "OTHER_OUTPUTS");
}

TEST_F(StudyStreamsTest, AComparisonNeedsNoFormulaAndAStudyOfSensorsDoes) {
  cell.on_executor([&] { studies.judgements = {judgement()}; });
  auto request = comparison();
  request.mutable_fit()->clear_formula();
  EXPECT_TRUE(compared<v1::CompareMethodsResponse>(request).second);
  request.set_fold_count(1);
  EXPECT_EQ(compared<v1::CompareMethodsResponse>(request).second.error().reason, "BAD_OPTION");
  v1::StudySensorsRequest study;
  study.mutable_fit()->add_run_ids(3);
  EXPECT_EQ(sensors(study).second.error().reason, "EMPTY_FORMULA");
  study.mutable_fit()->set_formula("q ~ x + T");
  study.set_tolerance(std::nan(""));
  EXPECT_EQ(sensors(study).second.error().reason, "BAD_OPTION");
  study.clear_tolerance();
  study.mutable_fit()->set_thread_count(-1);
  EXPECT_EQ(sensors(study).second.error().reason, "BAD_OPTION");
}

TEST_F(StudyStreamsTest, SetsOfThermometersComeInTheSummaryUnit) {
  cell.on_executor([&] {
    studies.choice.unit = "mm";
    calibration::SensorSet two, none;
    two.sensors = {"t01", "t04"};
    two.outputs = {{"q1", 30e-6, 4e-6, 31e-6, 35e-6, {}, {}}};
    two.u90_blocks_rms = 30e-6;
    two.a90_blocks_rms = 31e-6;
    none.outputs = {{"q1", 90e-6, 0, 90e-6, {}, {}, {}}};
    none.u90_blocks_rms = 90e-6;
    studies.choice.study = {{two, none}, 0, 4, 0.2};
  });
  v1::StudySensorsRequest request;
  request.mutable_fit()->add_run_ids(3);
  request.mutable_fit()->set_formula("q ~ x + T");
  request.set_tolerance(0.2);
  const auto [messages, end] = sensors(request);
  ASSERT_TRUE(end) << end.error().message;
  const auto& answer = messages.back();
  ASSERT_EQ(answer.best_size(), 2);
  EXPECT_EQ(answer.best(0).sensors(1), "t04");
  EXPECT_DOUBLE_EQ(answer.best(0).outputs(0).u90_validation(), 35);
  EXPECT_DOUBLE_EQ(answer.best(1).u90_blocks_rms(), 90);
  EXPECT_DOUBLE_EQ(answer.best(0).a90_blocks_rms(), 31);
  EXPECT_DOUBLE_EQ(answer.best(0).outputs(0).mean_blocks(), 4);
  EXPECT_EQ(answer.unit(), "nm");
  EXPECT_EQ(answer.tried_set_count(), 4);
  EXPECT_EQ(cell.on_executor([&] { return studies.last_sensors.tolerance; }), 0.2);
}

}  // namespace
}  // namespace driftwise::tests
