#include "server/application/models/model_list.h"

#include <gmock/gmock.h>

#include "server/formats/model/model_json.h"
#include "tests/unit/compensation/models.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::application {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

class ModelListTest : public testing::Test {
 protected:
  void keep(const std::string& name, const std::string& source) {
    auto model = compensation::axis_model();
    model.outputs[0].accuracy.rmse = 8e-6;
    model.lineage.source = source;
    ModelRecord record;
    record.name = name;
    record.json = formats::write_model_json(model);
    record.hash = formats::model_hash(model);
    record.created_by = "ada";
    ASSERT_TRUE(store->models().add_model(record));
  }
  void change(const std::string& sql) {
    storage::Database(path, SQLITE_OPEN_READWRITE, "").execute(sql);
  }

  storage::TemporaryFolder folder;
  const std::string path = folder / "cell.db";
  std::unique_ptr<Store> store = storage::open_store(path);
  ModelList list;
};

TEST_F(ModelListTest, ReadsTheTextOfAModelOnce) {
  keep("first", "runs 1");
  const auto once = list.of(*store).value();
  ASSERT_THAT(once, SizeIs(1));
  ASSERT_TRUE(once[0].summary);
  EXPECT_EQ(once[0].record.name, "first");
  EXPECT_EQ(once[0].record.json, "");
  EXPECT_EQ(once[0].summary->lineage.source, "runs 1");
  EXPECT_EQ(once[0].summary->outputs[0].accuracy.rmse, 8e-6);
  EXPECT_EQ(once[0].summary->outputs[0].covariance.size(), 0) << "a summary";
  keep("second", "runs 2");
  const auto again = list.of(*store).value();
  ASSERT_THAT(again, SizeIs(2));
  EXPECT_EQ(again[0].summary, once[0].summary) << "the very same object";
  EXPECT_EQ(again[1].summary->lineage.source, "runs 2");
}

// As a disk or a person might, while the daemon is there.
TEST_F(ModelListTest, SeesThatATextWasChangedSinceItWasRead) {
  keep("first", "runs 1");
  keep("second", "runs 2");
  ASSERT_TRUE(list.of(*store));
  change(
      "UPDATE model SET json = replace(json, '\"p_enter\":0.05', '\"p_enter\":0.06') "
      "WHERE model_id = 1");
  const auto changed = list.of(*store).value();
  EXPECT_THAT(changed[0].record.damage, HasSubstr("hash"));
  EXPECT_FALSE(changed[0].summary);
  EXPECT_EQ(changed[1].record.damage, "");
  change(
      "UPDATE model SET json = replace(json, '\"p_enter\":0.06', '\"p_enter\":0.05') "
      "WHERE model_id = 1");
  const auto mended = list.of(*store).value();
  EXPECT_EQ(mended[0].record.damage, "");
  EXPECT_TRUE(mended[0].summary);
}

TEST_F(ModelListTest, ListsAModelThatCannotBeReadWithItsDamage) {
  keep("first", "runs 1");
  keep("second", "runs 2");
  change("UPDATE model SET json = substr(json, 1, 100) WHERE model_id = 1");
  const auto listed = list.of(*store).value();
  ASSERT_THAT(listed, SizeIs(2));
  EXPECT_THAT(listed[0].record.damage, HasSubstr("model 1"));
  EXPECT_FALSE(listed[0].summary);
  EXPECT_TRUE(listed[1].summary);
}

}  // namespace
}  // namespace driftwise::application
