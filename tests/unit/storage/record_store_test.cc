// Models, promotions and events, and texts that try to be something else.

#include "storage/datasets/dataset_columns.h"
#include "storage/rows/place_text.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using RecordStoreTest = StoreTest;

ModelRecord example_model(const std::string& hash, std::optional<ModelId> parent = {}) {
  return {{},    "ten sensors", R"({"schema":"driftwise.model.v1"})", hash, parent, at_s(5).utc,
          "ada", "first try"};
}

TEST_F(RecordStoreTest, KeepsModelsWithTheirLineage) {
  const ModelId first = store->models().add_model(example_model("aa")).value();
  const ModelId second = store->models().add_model(example_model("bb", first)).value();
  EXPECT_EQ(store->models().add_model(example_model("aa")).value(), first);  // the same model again
  reopen();
  const ModelRecord model = store->models().model(second).value();
  EXPECT_EQ(model.parent, first);
  EXPECT_EQ(model.json, R"({"schema":"driftwise.model.v1"})");
  EXPECT_EQ(model.created, at_s(5).utc);
  EXPECT_EQ(store->models().models()->size(), 2u);
  EXPECT_EQ(store->models().model(ModelId{9}).error().reason, "NO_SUCH_MODEL");
  EXPECT_EQ(store->models().add_model(example_model("cc", ModelId{9})).error().code,
            ErrorCode::not_found);
}

TEST_F(RecordStoreTest, KeepsPromotionsInOrder) {
  const ModelId model = store->models().add_model(example_model("aa")).value();
  ASSERT_TRUE(store->models().add_promotion({model, at_s(1).utc, "ada", "promote"}));
  ASSERT_TRUE(store->models().add_promotion({std::nullopt, at_s(2).utc, "bob", "rollback"}));
  const auto promotions = store->models().promotions().value();
  ASSERT_EQ(promotions.size(), 2u);
  EXPECT_EQ(promotions[0].model, model);
  EXPECT_EQ(promotions[1].model, std::nullopt);
  EXPECT_EQ(promotions[1].by, "bob");
  EXPECT_EQ(store->models().add_promotion({ModelId{9}, at_s(3).utc, "ada", "promote"}).error().code,
            ErrorCode::not_found);
}

TEST_F(RecordStoreTest, KeepsEventsInOrderByPages) {
  for (int i = 0; i < 5; ++i)
    ASSERT_TRUE(store->events().add_event({{},
                                           at_s(i),
                                           "ada",
                                           "ipv4:127.0.0.1:5020",
                                           "lease.taken",
                                           "Lease " + std::to_string(i) + ".",
                                           i == 3 ? std::optional(run) : std::nullopt}));
  const auto first = store->events().events({0}, 2).value();
  ASSERT_EQ(first.size(), 2u);
  const auto rest = store->events().events(first.back().id, 0).value();
  ASSERT_EQ(rest.size(), 3u);
  EXPECT_EQ(rest[1].detail, "Lease 3.");
  EXPECT_EQ(rest[1].run, run);
  EXPECT_EQ(rest[1].from, "ipv4:127.0.0.1:5020");
  EXPECT_EQ(rest[2].run, std::nullopt);
}

TEST_F(RecordStoreTest, TakesAnyTextAsItIs) {
  using namespace std::string_literals;
  for (const std::string& text :
       {"Robert'); DROP TABLE run;--"s, "\"quoted\" `ticks` [brackets] ?1 :a @b $c"s,
        "zero\0inside\0"s, "Grüße, 微米, \xf0\x9f\x94\xac"s, "not \xff\xfe UTF-8"s,
        "line\r\nline\ttab\x01"s, ""s, std::string(300000, 'x')}) {
    NewRun wanted = example_run(text);
    wanted.trajectory_text = wanted.trajectory_name = wanted.operator_name = wanted.config_hash =
        text;
    const RunId id = store->runs().create_run(wanted).value().id;
    RunChange change;
    change.reason = text;
    ASSERT_TRUE(store->runs().change_run(id, change));
    const DatumId opened = store->points().open_datum(example_datum(id)).value();
    PointCommit commit = example_commit(id, opened, 0);
    commit.attempts[0].reason = text;
    commit.slow_readings[0].device = text;
    commit.moves[0].cause = text;
    ASSERT_TRUE(store->points().commit(commit));
    const RunRecord record = store->runs().run(id).value();
    EXPECT_EQ(record.name, text);
    EXPECT_EQ(record.trajectory_text, text);
    EXPECT_EQ(record.operator_name, text);
    EXPECT_EQ(record.config_hash, text);
    EXPECT_EQ(record.reason, text);
    EXPECT_EQ(store->points().attempts(id)->at(0).reason, text);
    if (!text.empty()) {  // empty asks for every device
      EXPECT_EQ(store->readings().readings(text, {0}, at_s(1e6).utc, 1)->at(0).device, text);
    }
    const EventId event =
        store->events().add_event({{}, at_s(0), text, text, text, text, {}}).value();
    EXPECT_EQ(store->events().events({event.value - 1}, 0)->at(0).detail, text);
  }
  EXPECT_EQ(store->runs().runs(0, 0)->size(), 9u);
}

TEST(PlaceText, ReadsWhatItWroteAndNothingElse) {
  for (const std::vector<Requeued>& requeued :
       {std::vector<Requeued>{}, {{3, 1}}, {{12, 1}, {0, 2}, {9007199254740993, 3}}})
    EXPECT_EQ(requeued_from(requeued_text(requeued)), requeued);
  for (const char* text : {"1", "1:", ":1", "1:2 ", " 1:2", "1:2,3:4", "1:2  3:4", "x", "1:2x",
                           "99999999999999999999:1"})
    EXPECT_EQ(requeued_from(text), std::nullopt) << text;
}

TEST(DatasetColumns, StandInTheOrderOfTheFormat) {
  std::vector<Channel> channels;
  for (const char* name : {"air_degC", "t10_degC", "x_std_nm", "ry_arcsec", "q2_mm", "t02_degC",
                           "q1_cmd_mm", "force_N", "x_mm", "q10_mm", "q1_mm", "support_degC"})
    channels.push_back(parse_channel(name).value());
  sort_as_dataset(channels);
  std::vector<std::string> names;
  for (const Channel& channel : channels) names.push_back(channel.name());
  EXPECT_THAT(names, testing::ElementsAre("q1_mm", "q2_mm", "q10_mm", "q1_cmd_mm", "x_mm",
                                          "ry_arcsec", "x_std_nm", "t02_degC", "t10_degC",
                                          "air_degC", "force_N", "support_degC"));
}

}  // namespace
}  // namespace driftwise::storage
