#include "server/formats/model/model_json.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "server/formats/text/text.h"
#include "tests/unit/compensation/models.h"

namespace driftwise::formats {
namespace {

using compensation::axis_model;
using compensation::power;
using compensation::term;

calibration::Model full_model() {
  auto model = axis_model();
  auto& q1 = model.outputs[0];
  q1.coefficients[1] = 1.0 / 3.0;
  q1.covariance(0, 1) = q1.covariance(1, 0) = 4.9406564584124654e-324;
  q1.noise_variance = 2.0 / 3.0 * 1e-10;
  q1.influences = {{"x_mm", "zero", 0.3, Eigen::VectorXd::LinSpaced(5, 0.1, 0.3)}};
  q1.accuracy.rmse = 8.1e-6;
  q1.accuracy.u90_validation = 1.4e-5;
  q1.accuracy.lag1_autocorrelation = 0.25;
  q1.accuracy.condition_index = 31;
  q1.accuracy.model_f = 4e9;
  q1.accuracy.validation_sets = {{"inside", {.rows = 150, .mean = 1e-6, .u90 = 7e-6, .a90 = 8e-6}},
                                 {"warm", {.rows = 298, .mean = -2e-6, .u90 = 9e-6, .a90 = 1e-5}}};
  calibration::TermReport report;
  report.term = {{effects::Power{"x", 2}, effects::Call{"rate", {"t07"}, {{300.5, "s"}, {2, ""}}}}};
  report.in = true;
  report.note = "cannot be told apart from x^2";
  report.coefficient = -1e-7;
  report.t = std::numeric_limits<double>::infinity();
  report.vif = std::numeric_limits<double>::quiet_NaN();
  q1.report = {report};
  q1.history = {
      {.step = 1, .action = "enter", .term = term({power("x")}), .p = 0, .rmse = 1e-3, .dof = 99}};
  model.lineage = {.runs = {RunId{3}, RunId{4}},
                   .source = "runs 3, 4 \"quoted\" µ",
                   .dataset_hash = "abc",
                   .rows_calibration = 560,
                   .rows_validation = 448,
                   .rows_dropped = 1,
                   .rows_excluded = 2,
                   .exclusions_hash = "def",
                   .parent = ModelId{2},
                   .measured_by = {{"z", {{{"probe"}, 500}, {{"laser", "probe"}, 60}}}}};
  model.warnings = {"t05 and t06 are nearly interchangeable"};
  model.fit_us = 48.1;
  return model;
}

TEST(ModelJson, ReadsBackTheSameModelToTheLastBit) {
  const auto model = full_model();
  const std::string text = write_model_json(model);
  const auto back = read_model_json(text);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->outputs[0].terms, model.outputs[0].terms);
  EXPECT_EQ(back->outputs[0].coefficients, model.outputs[0].coefficients);
  EXPECT_EQ(back->outputs[0].covariance, model.outputs[0].covariance);
  EXPECT_EQ(back->outputs[0].noise_variance, model.outputs[0].noise_variance);
  ASSERT_EQ(back->outputs[0].influences.size(), 1u);
  EXPECT_EQ(back->outputs[0].influences[0].by, "zero");
  EXPECT_EQ(back->outputs[0].influences[0].shift, model.outputs[0].influences[0].shift);
  EXPECT_EQ(back->outputs[0].report[0].term, model.outputs[0].report[0].term);
  EXPECT_EQ(back->outputs[0].report[0].t, model.outputs[0].report[0].t);
  EXPECT_EQ(back->outputs[0].history[0].action, "enter");
  EXPECT_EQ(back->outputs[0].accuracy.u90_validation, 1.4e-5);
  EXPECT_FALSE(back->outputs[0].accuracy.u90_blocks);
  ASSERT_EQ(back->outputs[0].accuracy.validation_sets.size(), 2u);
  EXPECT_EQ(back->outputs[0].accuracy.validation_sets[1].name, "warm");
  EXPECT_EQ(back->outputs[0].accuracy.validation_sets[1].figures,
            model.outputs[0].accuracy.validation_sets[1].figures);
  EXPECT_EQ(back->lineage.measured_by, model.lineage.measured_by);
  EXPECT_EQ(back->outputs[0].accuracy.model_f, 4e9);
  EXPECT_EQ(back->outputs[0].report[0].note, model.outputs[0].report[0].note);
  EXPECT_EQ(back->lineage.parent, ModelId{2});
  EXPECT_EQ(back->lineage.runs, model.lineage.runs);
  EXPECT_EQ(back->lineage.rows_excluded, 2);
  EXPECT_EQ(back->lineage.exclusions_hash, "def");
  EXPECT_EQ(back->domain[1].channel.name(), "t07_degC");
  EXPECT_EQ(write_model_json(*back), text);  // and with it everything else
  EXPECT_EQ(write_model_json(*read_model_json(write_model_json(model, 2))), text);
}

TEST(ModelJson, ReadsModelsOfBeforeRowsCouldBeExcluded) {
  std::string text = write_model_json(full_model());
  const std::string added = ",\"rows_excluded\":2,\"exclusions_hash\":\"def\"";
  ASSERT_NE(text.find(added), std::string::npos);
  text.erase(text.find(added), added.size());
  const auto back = read_model_json(text);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->lineage.rows_excluded, 0);
}

TEST(ModelJson, PrintsEveryTermAsNotationForPeople) {
  const auto json = nlohmann::json::parse(write_model_json(full_model()));
  EXPECT_EQ(json["schema"], "driftwise.model.v1");
  EXPECT_EQ(json["outputs"][0]["terms"][2]["term"], "x^2");
}

TEST(ModelHash, ForgetsOnlyHowLongTheFitTook) {
  auto model = full_model();
  const auto hash = model_hash(model);
  model.fit_us = 1000;
  EXPECT_EQ(model_hash(model), hash);
  model.outputs[0].coefficients[0] = std::nextafter(model.outputs[0].coefficients[0], 2.0);
  EXPECT_NE(model_hash(model), hash);
}

struct ModelMistake {
  const char* name;
  const char* pointer;
  const char* value;
  const char* says;
};
class BadModel : public testing::TestWithParam<ModelMistake> {};
TEST_P(BadModel, IsRefusedWithPlaceFoundAndExpected) {
  auto json = nlohmann::json::parse(write_model_json(full_model()));
  json[nlohmann::json::json_pointer(GetParam().pointer)] = nlohmann::json::parse(GetParam().value);
  const auto model = read_model_json(json.dump());
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().reason, "BAD_MODEL");
  EXPECT_TRUE(model.error().message.find(GetParam().says) != std::string::npos)
      << model.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    Table, BadModel,
    testing::Values(
        ModelMistake{"Schema", "/schema", "\"driftwise.fit.v1\"",
                     "schema: found '\"driftwise.fit.v1\"', expected 'driftwise.model.v1'"},
        ModelMistake{"Coefficient", "/outputs/0/terms/1/coefficient", "\"nan\"",
                     "outputs[0].terms[1].coefficient: found '\"nan\"', expected a finite number"},
        ModelMistake{"Rows", "/outputs/0/covariance", "[]",
                     "outputs[0].covariance: found an array of 0, expected 5 rows"},
        ModelMistake{"Columns", "/outputs/0/covariance/2", "[1]",
                     "outputs[0].covariance[2]: found an array of 1, expected 5 numbers"},
        ModelMistake{"Channel", "/outputs/0/channel", "\"q1\"",
                     "outputs[0].channel: found '\"q1\"', expected a channel"},
        ModelMistake{"Exponent", "/outputs/0/terms/2/factors/0/exponent", "0",
                     "exponent: found '0', expected a whole number from 1 to 64"},
        ModelMistake{"Domain", "/domain/0/min", "null",
                     "domain[0].min: found 'null', expected a finite number"},
        ModelMistake{"Runs", "/lineage/runs/1", "1.5",
                     "lineage.runs[1]: found '1.5', expected a whole number"}),
    [](const auto& row) { return std::string(row.param.name); });

// FIPS 180-4's "abc", and the FNV-1a of draft-eastlake-fnv of "a": what programs before wrote.
TEST(ContentHash, IsSha256AndReadsTheOlderFormInItsOwn) {
  EXPECT_EQ(content_hash("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(content_hash_like("0123456789abcdef", "a"), "af63dc4c8601ec8c");
  EXPECT_EQ(content_hash_like(content_hash("b"), "a"), content_hash("a"));
}

TEST(ReadModelJson, NamesLineAndColumnOfASyntaxError) {
  const auto model = read_model_json("{\n  \"schema\": oops\n}");
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().reason, "JSON_SYNTAX");
  EXPECT_TRUE(model.error().message.starts_with("line 2, column 1")) << model.error().message;
}

TEST(ReadModelJson, NamesAMissingKey) {
  const auto model = read_model_json("{\"schema\": \"driftwise.model.v1\"}");
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().message, "formula: found nothing, expected this key");
}

}  // namespace
}  // namespace driftwise::formats
