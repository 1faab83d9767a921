// Indentations in the record.

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

class IndentationStoreTest : public StoreTest {
 protected:
  static IndentationRecord begun(const std::string& key) {
    IndentationRecord record;
    record.key = key;
    record.file_text = "name = \"case C.2\"";
    record.record_json = "{\"contacts\": 0}";
    record.created = record.reported = at_s(3).utc;
    record.created_by = "ada";
    record.created_from = "ipv4:127.0.0.1:1";
    return record;
  }
};

TEST_F(IndentationStoreTest, KeepsWhatWasReportedLast) {
  auto record = store->indentations().add_indentation(begun("a")).value();
  record.record_json = "{\"contacts\": 4}";
  record.ended = "interrupted";
  record.microscope_csv = "id,x_um\n";
  record.reported = at_s(9).utc;
  ASSERT_TRUE(store->indentations().change_indentation(record));
  const auto kept = store->indentations().indentation(record.id).value();
  EXPECT_EQ(kept.record_json, "{\"contacts\": 4}");
  EXPECT_EQ(kept.ended, "interrupted");
  EXPECT_EQ(kept.microscope_csv, "id,x_um\n");
  EXPECT_EQ(kept.reported, at_s(9).utc);
  EXPECT_EQ(kept.created, at_s(3).utc);
  EXPECT_EQ(kept.created_by, "ada");
}

TEST_F(IndentationStoreTest, AnswersARepeatedKeyWithTheRecordThatIsThere) {
  auto first = store->indentations().add_indentation(begun("a")).value();
  first.record_json = "{\"contacts\": 4}";
  ASSERT_TRUE(store->indentations().change_indentation(first));
  const auto again = store->indentations().add_indentation(begun("a")).value();
  EXPECT_EQ(again.id, first.id);
  EXPECT_EQ(again.record_json, "{\"contacts\": 4}");
}

TEST_F(IndentationStoreTest, ListsTheNewestFirst) {
  store->indentations().add_indentation(begun("a")).value();
  const auto second = store->indentations().add_indentation(begun("b")).value();
  const auto listed = store->indentations().indentations(10).value();
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0].id, second.id);
  EXPECT_EQ(store->indentations().indentations(1)->size(), 1u);
}

TEST_F(IndentationStoreTest, RefusesANumberThatIsNotThere) {
  auto record = begun("a");
  record.id = {7};
  EXPECT_EQ(store->indentations().change_indentation(record).error().reason, "NO_SUCH_RECORD");
  EXPECT_EQ(store->indentations().indentation({7}).error().reason, "NO_SUCH_RECORD");
}

}  // namespace
}  // namespace driftwise::storage
