// Costs of long runs, counted in steps of SQLite's machine and in rows that it sorts: the same on
// every computer.

#include <algorithm>

#include "storage/datasets/dataset_rows.h"
#include "storage/rows/point_rows.h"
#include "storage/watch/remark_store.h"
#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class LongRuns : public StoreTest {
 protected:
  struct Cost {
    std::int64_t steps = 0, sorts = 0;
  };

  RunId import(std::size_t rows, const std::string& name) {
    Dataset file;
    file.rows = rows;
    file.columns.push_back({{"x", "mm"}, std::vector<double>(rows, 0.5)});
    return store->runs().import_dataset(example_run(name), file).value().id;
  }
  void add_points(int first_row, int count) {
    for (int row = first_row; row < first_row + count; ++row)
      ASSERT_TRUE(store->points().commit(example_commit(run, datum, row)));
  }
  // All statements of a connection of its own.
  template <class Work>
  Cost cost_of(Work&& work) const {
    Session session(path, SQLITE_OPEN_READONLY, "", true);
    work(session);
    Cost cost;
    for (sqlite3_stmt* one = sqlite3_next_stmt(session.db.handle(), nullptr); one != nullptr;
         one = sqlite3_next_stmt(session.db.handle(), one)) {
      cost.steps += sqlite3_stmt_status(one, SQLITE_STMTSTATUS_VM_STEP, 0);
      cost.sorts += sqlite3_stmt_status(one, SQLITE_STMTSTATUS_SORT, 0);
    }
    return cost;
  }
  std::vector<std::int64_t> rows_by_pages(RunId of, int limit) {
    std::vector<std::int64_t> rows;
    std::int64_t after = 0;
    for (;;) {
      const auto page = store->points().points(of, after, limit).value();
      EXPECT_LE(page.size(), static_cast<std::size_t>(limit));
      for (const auto& point : page) {
        EXPECT_EQ(point.run, of);
        EXPECT_GT(point.id.value, after);
        after = point.id.value;
        rows.push_back(point.row);
      }
      if (page.empty()) return rows;
    }
  }
};

TEST_F(LongRuns, GiveAPageForThePriceOfItsRows) {
  const RunId shorter = import(500, "shorter"), longer = import(4000, "longer");
  const auto page_of = [&](RunId of, std::int64_t skipped) {
    const auto before = store->points().points(of, 0, static_cast<int>(skipped)).value();
    const std::int64_t after = before.back().id.value;
    return cost_of(
        [&](Session& session) { EXPECT_EQ(read_points(session, of, after, 100).size(), 100U); });
  };
  const Cost floor = page_of(shorter, 100), late = page_of(longer, 3500);
  EXPECT_EQ(late.sorts, 0);
  EXPECT_EQ(late.steps, floor.steps) << "eight times the rows";
}

// Imports come between the points of a run that goes on.
TEST_F(LongRuns, GiveEveryPointOnceByPagesOfAnySizeWhateverCameBetween) {
  add_points(0, 3);
  const RunId first = import(5, "between");
  add_points(3, 4);
  const RunId second = import(2, "between again");
  add_points(7, 1);
  for (const int limit : {1, 2, 3, 100}) {
    EXPECT_THAT(rows_by_pages(run, limit), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7)) << limit;
    EXPECT_THAT(rows_by_pages(first, limit), ElementsAre(0, 1, 2, 3, 4)) << limit;
    EXPECT_THAT(rows_by_pages(second, limit), ElementsAre(0, 1)) << limit;
  }
  EXPECT_EQ(store->points().points(run, 0, 0)->size(), 8U) << "no limit";
  const RunId empty = store->runs().create_run(example_run("empty")).value().id;
  EXPECT_THAT(*store->points().points(empty, 0, 100), IsEmpty());
}

// The work for rows that are out grows with their number, not with its square.
TEST_F(LongRuns, AreReadWithRowsKeptOutForThePriceOfTheRows) {
  const RunId fewer = import(200, "fewer"), more = import(800, "more");
  const auto keep_out = [&](RunId of, std::int64_t rows) {
    for (std::int64_t row = 0; row < rows; ++row)
      ASSERT_TRUE(store->remarks().exclude({.id = 0,
                                            .run = of,
                                            .excluded = row % 4 != 3,
                                            .rows = {row % 4 == 3 ? row - 1 : row},
                                            .reason = "door open",
                                            .at = at_s(1),
                                            .who = "ada",
                                            .from = ""}));
  };
  keep_out(fewer, 200);
  keep_out(more, 800);
  std::size_t out = 0;
  const auto cost = [&](RunId of) {
    return cost_of([&](Session& session) {
      const auto rows = read_dataset_rows(session, of);
      out = static_cast<std::size_t>(std::ranges::count_if(rows, &DatasetRow::excluded));
    });
  };
  const Cost floor = cost(fewer);
  EXPECT_EQ(out, 100U) << "of four rows one was put back, one was never out";
  const Cost all = cost(more);
  EXPECT_EQ(out, 400U);
  EXPECT_LT(all.steps, 5 * floor.steps) << "four times the rows";
}

}  // namespace
}  // namespace driftwise::storage
