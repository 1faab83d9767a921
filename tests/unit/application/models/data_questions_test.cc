// What the data of a model ask before it serves.
#include "server/application/provenance/data_questions.h"

#include <gmock/gmock.h>

namespace driftwise::application {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

CellDescription cell_with(int thermometers_of_robot) {
  CellDescription cell;
  DeviceDescription controller;
  controller.settings = MotionSettings{{{{"q1", "mm"}, "X", -5, 5, 1}}};
  DeviceDescription scanner;
  TemperatureSettings probes;
  for (int i = 0; i < thermometers_of_robot; ++i) {
    ProbeDescription probe;
    probe.channel = {"t0" + std::to_string(i + 1), "degC"};
    probe.part = "robot";
    probes.probes.push_back(probe);
  }
  scanner.settings = probes;
  cell.devices = {controller, scanner};
  return cell;
}

effects::Term term_of(const std::string& symbol) { return {{effects::Power{symbol, 1}}}; }

calibration::Model model_of(const std::vector<std::string>& symbols, std::int64_t validation) {
  calibration::Model model;
  calibration::OutputModel output;
  output.channel = {"q1", "mm"};
  for (const auto& symbol : symbols) output.terms.push_back(term_of(symbol));
  model.outputs = {output};
  model.lineage.rows_calibration = 12;
  model.lineage.rows_validation = validation;
  return model;
}

DataOfModel night() { return {RunId{1}, "night", true, std::nullopt, 9 * 3600.0}; }

DataOfModel stranger(std::vector<double> q1_mm) {
  DataOfModel data{RunId{8}, "messung.csv", false, Dataset{}, std::nullopt};
  data.rows->rows = q1_mm.size();
  data.rows->columns = {{{"q1", "mm"}, std::move(q1_mm)}};
  return data;
}

TEST(OriginQuestions, AreNoneOfRunsThatThisCellMeasured) {
  EXPECT_THAT(origin_questions(model_of({"x"}, 3), {night()}, cell_with(1)), IsEmpty());
}

TEST(OriginQuestions, NameTheRunThatWasImported) {
  EXPECT_THAT(origin_questions(model_of({"x"}, 3), {night(), stranger({-5, 0, 5})}, cell_with(1)),
              ElementsAre(AllOf(
                  HasSubstr("this cell did not measure run 8 'messung.csv', which was imported"),
                  testing::Not(HasSubstr("soft limits")))));
}

TEST(OriginQuestions, NameItsPosesBeyondTheSoftLimits) {
  EXPECT_THAT(
      origin_questions(model_of({"x"}, 3), {stranger({-92, 0, kMissing, 94.5})}, cell_with(1)),
      ElementsAre(
          HasSubstr("with q1_mm from -92 to 94.5, in 2 rows beyond its soft limits -5 .. 5 mm")));
}

TEST(OriginQuestions, AreAskedOfAModelWithoutARun) {
  EXPECT_THAT(origin_questions(model_of({"x"}, 3), {}, cell_with(1)),
              ElementsAre(HasSubstr("its 15 rows, which are a file's")));
}

TEST(OriginQuestions, AreNoneOfARobotFileWithoutData) {
  auto model = model_of({"x"}, 0);
  model.lineage.rows_calibration = 0;
  EXPECT_THAT(origin_questions(model, {}, cell_with(1)), IsEmpty());
}

TEST(CampaignQuestions, AreNoneOfANightThatFollowsTheRobotsTemperatures) {
  EXPECT_THAT(campaign_questions(model_of({"x", "t01"}, 3), {night()}, cell_with(6), false),
              IsEmpty());
}

TEST(CampaignQuestions, CountTheThermometersThatNoTermReads) {
  EXPECT_THAT(campaign_questions(model_of({"x"}, 3), {night()}, cell_with(6), false),
              ElementsAre(HasSubstr("the cell has 6:")));
  EXPECT_THAT(campaign_questions(model_of({"x"}, 3), {night()}, cell_with(0), false), IsEmpty());
}

TEST(CampaignQuestions, AskWhereNoRowAndNoLaterRunJudgedTheModel) {
  const auto model = model_of({"x", "t01"}, 0);
  EXPECT_THAT(campaign_questions(model, {night()}, cell_with(6), false),
              ElementsAre(HasSubstr("all 12 rows made it")));
  EXPECT_THAT(campaign_questions(model, {night()}, cell_with(6), true), IsEmpty());
}

TEST(CampaignQuestions, StateHowShortTheCampaignWas) {
  auto first = night(), second = night();
  first.duration_s = 25;
  EXPECT_THAT(campaign_questions(model_of({"x", "t01"}, 3), {first}, cell_with(6), false),
              ElementsAre(HasSubstr("were measured within 25 s")));
  second.duration_s = 240;
  EXPECT_THAT(campaign_questions(model_of({"x", "t01"}, 3), {first, second}, cell_with(6), false),
              ElementsAre(HasSubstr("were measured within 4 min")));
  second.duration_s.reset();
  EXPECT_THAT(campaign_questions(model_of({"x", "t01"}, 3), {first, second}, cell_with(6), false),
              IsEmpty())
      << "a file without times";
}

TEST(CampaignQuestions, AreNoneOfARobotFileWithoutData) {
  auto model = model_of({"x"}, 0);
  model.lineage.rows_calibration = 0;
  EXPECT_THAT(campaign_questions(model, {}, cell_with(6), false), IsEmpty());
}

}  // namespace
}  // namespace driftwise::application
