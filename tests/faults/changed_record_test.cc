// A record that somebody changes with SQLite's library alone: every change is found and named, and
// so is a chain that was computed anew. What is attacked comes from docs/database.md.

#include <bit>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <regex>

#include "tests/unit/storage/store_fixture.h"

namespace driftwise::storage {
namespace {

// The tables of docs/database.md, "The chain": of each kind of unit, in order.
std::vector<std::string> protected_tables() {
  std::ifstream file(DRIFTWISE_SOURCE_DIR "/docs/database.md");
  static const std::regex kind(R"(^\| \d+ \| [^|]+ \| ([^|]+) \| (yes)? ?\|$)"), name("`(\\w+)`");
  std::vector<std::string> tables;
  for (std::string line; std::getline(file, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, kind)) continue;
    const std::string list = match[1];
    for (std::sregex_iterator hit(list.begin(), list.end(), name), end; hit != end; ++hit)
      tables.push_back((*hit)[1]);
  }
  return tables;
}

// Everything that a store can be told, at least once: no protected table is empty.
class WholeRecord {
 public:
  explicit WholeRecord(const std::string& path) {
    auto store = open_store(path);
    const std::string config = "[cell]\nname = \"linear-axis\"\n";
    const auto start = store->configurations().begin(
        {0, "c0ffee", "", "[]", true, "0.1.0", at_s(0), {}, "", ""}, config);
    EXPECT_TRUE(start);
    EXPECT_TRUE(
        store->clocks().add_clock({at_s(0).utc, Nanoseconds(7), Nanoseconds(0), "boot", 3, 4}));
    EXPECT_TRUE(store->configurations().begin(
        {0, "beef", "c0ffee", "[]", true, "0.1.0", at_s(0), {}, "", ""}, config + "# later\n"));
    const RunId run = store->runs().create_run(example_run()).value().id;
    EXPECT_TRUE(store->configurations().accept(start->id, at_s(1).utc, "ada", "seen", run));
    EXPECT_TRUE(store->configurations().continue_run(run, {"beef", at_s(1).utc}));
    const DatumId datum = store->points().open_datum(example_datum(run)).value();
    for (int row = 0; row < 40; ++row) {
      auto commit = example_commit(run, datum, row);
      if (row % 7 == 0) {
        const auto& reading = commit.attempts[0].readings[0];
        commit.rejected.push_back(
            {reading.device, reading.start, reading.sequence, {"x_mm", "range", "above 12 mm"}});
      }
      if (row % 20 == 10) commit.passages.push_back(*commit.point);
      EXPECT_TRUE(store->points().commit(commit));
    }
    QueueEntry entry;
    entry.id = {1};
    entry.name = "night";
    entry.created_by = "ada";
    entry.results = {{0, true, "people were notified", {}, {}, at_s(14).utc}};
    QueueChange change;
    change.put = {entry};
    EXPECT_TRUE(store->queue().change_queue(change));
    NewRun queued = example_run("night");
    queued.queue_entry = entry.id;
    queued.metadata = {{"sample", "A12"}};
    EXPECT_TRUE(store->runs().create_run(queued));
    Dataset file;
    file.rows = 4;
    file.columns.push_back({parse_channel("x_mm").value(), {1.5, -2.5, 0.0, 4.25}});
    file.metadata.emplace_back("cell", "elsewhere");
    EXPECT_TRUE(store->runs().import_dataset(example_run("import"), file));
    const auto model = store->models().add_model({{},
                                                  "ten sensors",
                                                  R"({"schema":"driftwise.model.v1"})",
                                                  "aa",
                                                  {},
                                                  at_s(5).utc,
                                                  "ada",
                                                  ""});
    EXPECT_TRUE(store->models().add_promotion({*model, at_s(6).utc, "ada", "promote"}));
    EXPECT_TRUE(store->events().add_event({{}, at_s(7), "ada", "p", "model.promote", "it", run}));
    PlanRecord plan;
    plan.name = "joint";
    plan.text = "name = \"joint\"\n";
    plan.hash = "dd";
    plan.models = {{*model, "aa"}};
    plan.created = at_s(6).utc;
    plan.created_by = "ada";
    const auto kept = store->plans().add_plan(plan);
    EXPECT_TRUE(kept);
    EXPECT_TRUE(store->plans().add_plan_promotion({kept->id, at_s(7).utc, "ada", "p", "promote"}));
    EXPECT_TRUE(store->remarks().add_time_note(
        {0, at_s(8).utc, "the door was open", "", "", at_s(9), "ada", "p"}));
    EXPECT_TRUE(store->remarks().exclude({0, run, true, {1, 3}, "late", at_s(8), "ada", "p"}));
    EXPECT_TRUE(store->remarks().exclude({0, run, true, {5}, "zero", at_s(8), "daemon", "", true}));
    EXPECT_TRUE(store->remarks().add_note({0, {run, {}, {}}, "a remark", at_s(9), "ada", "p"}));
    ClosureRecord closure;
    closure.run = run;
    closure.datum = datum;
    closure.line = 1;
    closure.measured = at_s(10);
    closure.decision = ClosureDecision::repeated;
    closure.coordinates = {{"x_mm", 412, 300, 12, 3, 2.5, 0}};
    EXPECT_TRUE(store->closures().add_closure(closure, RepeatedLine{{39}, 0, {39, {}}}));
    RestRecord rest;
    rest.begin = at_s(10).utc;
    rest.begun_by = "ada";
    EXPECT_TRUE(store->rests().begin_rest(rest));
    IndentationRecord indentation;
    indentation.key = "case C.2";
    indentation.file_text = "name = 'case C.2'";
    indentation.record_json = "{}";
    indentation.created = indentation.reported = at_s(11).utc;
    indentation.created_by = "ada";
    EXPECT_TRUE(store->indentations().add_indentation(indentation));
    explain(*store, run);
    EXPECT_TRUE(store->alarms().raise({{},
                                       AlarmLevel::warning,
                                       "device.lost",
                                       "laser-x",
                                       "gone",
                                       at_s(11).utc,
                                       {},
                                       {},
                                       "",
                                       {"the run waits"},
                                       0}));
    EXPECT_TRUE(
        store->trajectories().keep({{}, "plan", "q1_mm\n1\n", "ff", 1, at_s(12).utc, "ada"}));
    EXPECT_TRUE(store->stops().keep(std::vector{StopRecord{
        {}, "axis", "ada", "p", "stopped by ada", at_s(13), 1, {}, "ada", at_s(13).utc}}));
    AuditRecord act;
    act.at = at_s(14);
    act.by = {"ada", "stated", "ipv4:127.0.0.1:5020"};
    act.what = "stop";
    EXPECT_TRUE(store->audit().add(act, EventRecord{{}, at_s(14), "ada", "p", "stop", "", run}));
    thin(*store);
  }

 private:
  // Scans long after the points; those of the first minutes become rows of 10 s.
  void thin(Store& store) {
    std::vector<Reading> scans;
    for (int i = 0; i < 120; ++i)
      scans.push_back({"scanner",
                       at_s(9000 + i).utc,
                       at_s(9000.5 + i).utc,
                       1000 + i,
                       {{"t01_degC", 20.5 + 0.01 * i}}});
    EXPECT_TRUE(store.readings().append(scans, {}, {}));
    while (store.series().summarise().value()) {
    }
    const auto step =
        store.audit().thin({at_s(9060).utc, 10'000'000'000, "mean", at_s(20'000), act_by(), 0});
    EXPECT_TRUE(step);
    EXPECT_EQ(step->readings, 60);
  }
  static Identity act_by() { return {"ada", "stated", "unix:"}; }
  void explain(Store& store, RunId run) {
    DiagnosisRecord wanted;
    wanted.name = "why";
    wanted.runs = {run};
    wanted.created_by = "ada";
    const auto diagnosis = store.diagnoses().add_diagnosis(wanted).value().id;
    EXPECT_TRUE(store.diagnoses().end_diagnosis(
        diagnosis, {JobState::done, "", "q ~ x", "{}", std::string("\x01rows"), at_s(10).utc}));
    NewExtension made;
    made.diagnosis = diagnosis;
    made.findings = {1};
    made.correction_json = R"({"schema":"driftwise.correction.v1"})";
    made.changes = {{run, "", "x_mm", at_s(20).utc, 3, 12.5, 4.5, true}};
    made.exclusions = {{0, run, true, {7}, "outlier", {}, "", ""}};
    made.fitted = ModelRecord{{}, "extended", "{}", "bb", {}, at_s(10).utc, "ada", ""};
    made.rests_on_this = true;
    made.at = at_s(10);
    made.who = "ada";
    EXPECT_TRUE(store.extensions().accept(made));
    ImprovementRecord loop;
    loop.trajectory_name = "plan.csv";
    const auto improvement = store.improvements().add_improvement(loop).value().id;
    ImprovementTurn turn;
    turn.runs = {run};
    turn.what = "measured";
    TurnGain gain;
    gain.output = "q1";
    gain.unit = "nm";
    gain.before = {.u90 = 60.0, .a90 = 61.0};
    turn.gains = {gain};
    EXPECT_TRUE(store.improvements().put_turn(improvement, turn));
  }
};

struct Column {
  std::string name;
  bool in_key;
};

// One table as the attacker sees it.
struct Target {
  std::string table;
  std::vector<Column> columns;  // stored ones
  std::vector<std::string> key;
  std::int64_t rows = 0;
};

class Attacker {
 public:
  explicit Attacker(const std::string& path) : db_(path, SQLITE_OPEN_READWRITE, "") {
    db_.execute("PRAGMA ignore_check_constraints = ON; PRAGMA foreign_keys = OFF");
    for (const auto& table : protected_tables()) {
      Target target{table, {}, {}, 0};
      Query columns(db_, "SELECT name, pk FROM pragma_table_xinfo(?) WHERE hidden = 0");
      columns.bind(table);
      while (columns.row()) {
        target.columns.push_back({columns.text(0), columns.integer(1) > 0});
        if (columns.integer(1) > 0) target.key.push_back(columns.text(0));
      }
      target.rows = number("SELECT count(*) FROM " + table);
      targets_.push_back(std::move(target));
    }
  }

  const std::vector<Target>& targets() const { return targets_; }
  std::int64_t number(const std::string& sql) { return std::stoll(one(sql)); }
  std::string one(const std::string& sql) {
    std::string found;
    db_.for_each_row(sql, [&](const std::string& text) { found = text; });
    return found;
  }
  bool done(const std::string& sql) {
    return sqlite3_exec(db_.handle(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK;
  }

  // "a = 1 AND b = 'x'": the row of this number.
  std::string where(const Target& target, std::int64_t row) {
    std::string list;
    for (const auto& column : target.key)
      list += (list.empty() ? "" : " || ' AND ' || ") + ("'" + column + " = ' || quote(") + column +
              ")";
    return one("SELECT " + list + " FROM " + target.table + " LIMIT 1 OFFSET " +
               std::to_string(row));
  }
  // A literal that SQLite reads back to the last bit.
  std::string literal(const Target& target, const std::string& column, const std::string& where) {
    const std::string from = " FROM " + target.table + " WHERE " + where;
    const std::string type = one("SELECT typeof(" + column + ")" + from);
    if (type == "text") return "CAST(x'" + one("SELECT hex(" + column + ")" + from) + "' AS TEXT)";
    if (type == "blob") return "x'" + one("SELECT hex(" + column + ")" + from) + "'";
    if (type == "real") return real_literal(real(column, from));
    return one("SELECT quote(" + column + ")" + from);
  }
  double real(const std::string& column, const std::string& from) {
    sqlite3_stmt* raw = nullptr;
    const std::string sql = "SELECT " + column + from;
    EXPECT_EQ(sqlite3_prepare_v2(db_.handle(), sql.c_str(), -1, &raw, nullptr), SQLITE_OK);
    sqlite3_step(raw);
    const double value = sqlite3_column_double(raw, 0);
    sqlite3_finalize(raw);
    return value;
  }
  static std::string real_literal(double value) {
    if (std::isinf(value)) return value > 0 ? "9e999" : "-9e999";
    if (std::isnan(value)) return "NULL";
    if (value == 0 && std::signbit(value)) return "-0.0";
    char text[40];
    std::snprintf(text, sizeof text, "%.17e", value);
    return text;
  }

  // The value with one byte of it changed, as a literal; NULL and empty ones get a first byte.
  std::string changed(const Target& target, const std::string& column, const std::string& where,
                      std::mt19937_64& random) {
    const std::string from = " FROM " + target.table + " WHERE " + where;
    const std::string type = one("SELECT typeof(" + column + ")" + from);
    const auto flip = 1 + random() % 255;
    if (type == "integer") {
      const auto bits = static_cast<std::uint64_t>(number("SELECT " + column + from)) ^
                        (flip << (8 * (random() % 8)));
      const auto value = static_cast<std::int64_t>(bits);
      return value == std::numeric_limits<std::int64_t>::min() ? "(-9223372036854775807 - 1)"
                                                               : std::to_string(value);
    }
    if (type == "real")
      return real_literal(std::bit_cast<double>(std::bit_cast<std::uint64_t>(real(column, from)) ^
                                                (flip << (8 * (random() % 8)))));
    if (type == "null") return "0.0";
    std::string hex = one("SELECT hex(" + column + ")" + from);
    if (hex.empty()) {
      hex = "41";
    } else {
      const std::size_t at = 2 * (random() % (hex.size() / 2));
      const auto byte = std::stoul(hex.substr(at, 2), nullptr, 16) ^ flip;
      char text[3];
      std::snprintf(text, sizeof text, "%02X", static_cast<unsigned>(byte));
      hex.replace(at, 2, text);
    }
    return type == "text" ? "CAST(x'" + hex + "' AS TEXT)" : "x'" + hex + "'";
  }

 private:
  Database db_;
  std::vector<Target> targets_;
};

class ChangedRecord : public testing::Test {
 protected:
  ChangedRecord() {
    restore();
    Attacker attacker(path);
    targets = attacker.targets();
  }
  void restore() {
    for (const char* log : {"-wal", "-shm"}) std::filesystem::remove(path + log);
    std::filesystem::copy_file(whole, path, std::filesystem::copy_options::overwrite_existing);
  }
  // One change of a fresh copy; false: SQLite refused it.
  bool change(const std::string& sql) {
    restore();
    return Attacker(path).done(sql);
  }
  ChainReport verified(const std::optional<ChainHead>& outside = {}) const {
    return open_store(path, true)->audit().verify(outside, {}).value();
  }

  TemporaryFolder folder;
  std::string whole = folder / "whole.db", path = folder / "cell.db";
  WholeRecord record{whole};
  std::vector<Target> targets;
};

TEST_F(ChangedRecord, IsWholeBeforeAndHasRowsInEveryProtectedTable) {
  const auto report = verified();
  EXPECT_TRUE(report.intact()) << report.first.front();
  ASSERT_EQ(targets.size(), 59U) << "the list of docs/database.md";
  for (const auto& target : targets) EXPECT_GT(target.rows, 0) << target.table;
}

TEST_F(ChangedRecord, IsFoundAtEachOfAThousandSingleBytes) {
  std::mt19937_64 random(20261122);
  int tried = 0, refused = 0, found = 0, named = 0;
  std::map<std::string, int> columns;
  while (tried < 1000) {
    const auto& target = targets[random() % targets.size()];
    const auto& column = target.columns[random() % target.columns.size()].name;
    restore();
    std::string sql;
    {
      Attacker attacker(path);
      const auto row =
          static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(target.rows));
      const std::string where = attacker.where(target, row);
      sql = "UPDATE " + target.table + " SET " + column + " = " +
            attacker.changed(target, column, where, random) + " WHERE " + where;
      if (!attacker.done(sql)) {  // a unique index, or another type
        ++refused;
        continue;
      }
    }
    ++tried;
    ++columns[target.table + "." + column];
    const auto report = verified();
    EXPECT_FALSE(report.intact()) << sql;
    if (report.intact()) continue;
    ++found;
    const bool right = report.first.front().starts_with(target.table + " with ");
    EXPECT_TRUE(right) << sql << ": " << report.first.front();
    named += right ? 1 : 0;
  }
  std::printf(
      "single bytes changed: %d; found: %d; named by table and row: %d; refused by SQLite itself: "
      "%d; columns: %zu\n",
      tried, found, named, refused, columns.size());
  EXPECT_EQ(found, 1000);
  EXPECT_EQ(named, 1000);
}

TEST_F(ChangedRecord, IsFoundWhereRowsAreRemovedInsertedOrSwapped) {
  int removed = 0, inserted = 0, swapped = 0;
  for (const auto& target : targets) {
    Attacker attacker(whole);  // only reads there
    const std::string first = attacker.where(target, 0);
    const std::string last = attacker.where(target, target.rows - 1);
    for (const auto& where : {first, last}) {
      ASSERT_TRUE(change("DELETE FROM " + target.table + " WHERE " + where)) << target.table;
      const auto report = verified();
      ASSERT_FALSE(report.intact()) << target.table;
      EXPECT_THAT(report.first.front(), testing::StartsWith(target.table + " with "));
      EXPECT_THAT(report.first.front(), testing::HasSubstr(" is missing since entry "));
      ++removed;
    }
    std::string values, names;
    for (const auto& column : target.columns) {
      const bool counts = column.name == target.key.back();
      names += (names.empty() ? "" : ", ") + column.name;
      values += (values.empty() ? "" : ", ") + column.name +
                (!counts                         ? ""
                 : target.table == "cell_config" ? " || 'x'"
                                                 : " + 1000003");
    }
    if (change("INSERT INTO " + target.table + " (" + names + ") SELECT " + values + " FROM " +
               target.table + " WHERE " + last)) {
      const auto report = verified();
      ASSERT_FALSE(report.intact()) << target.table;
      EXPECT_THAT(report.first.front(), testing::StartsWith(target.table + " with "));
      EXPECT_THAT(report.first.front(), testing::HasSubstr(" is inserted"));
      ++inserted;
    }
    if (target.rows < 2) continue;
    for (const auto& column : target.columns) {
      if (column.in_key) continue;
      const std::string one = attacker.literal(target, column.name, first);
      const std::string other = attacker.literal(target, column.name, last);
      if (one == other) continue;
      if (!change("UPDATE " + target.table + " SET " + column.name + " = CASE WHEN " + first +
                  " THEN " + other + " ELSE " + one + " END WHERE (" + first + ") OR (" + last +
                  ")"))
        continue;
      EXPECT_FALSE(verified().intact()) << target.table << "." << column.name;
      ++swapped;
    }
  }
  std::printf("rows removed: %d, inserted: %d, pairs of values swapped: %d; all found\n", removed,
              inserted, swapped);
  EXPECT_GT(inserted, 30);
  EXPECT_GT(swapped, 50);
}

// Where a row lies in the file is no part of the record.
TEST_F(ChangedRecord, IsWholeWhenTheFileIsWrittenAnew) {
  ASSERT_TRUE(change("VACUUM"));
  EXPECT_TRUE(verified().intact());
}

TEST_F(ChangedRecord, IsFoundInTheChainItself) {
  const auto entries = Attacker(whole).number("SELECT max(entry_id) FROM chain");
  std::mt19937_64 random(7);
  for (int i = 0; i < 60; ++i) {
    restore();
    Attacker attacker(path);
    const Target chain{"chain", {}, {"entry_id"}, entries};
    const std::string column = std::vector{"entry_id", "what", "bytes", "head"}[random() % 4];
    const std::string where = attacker.where(
        chain, static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(entries)));
    if (!attacker.done("UPDATE chain SET " + column + " = " +
                       attacker.changed(chain, column, where, random) + " WHERE " + where))
      continue;
    EXPECT_FALSE(verified().intact()) << column << " " << where;
  }
  ASSERT_TRUE(
      change("UPDATE chain SET entry_id = -entry_id WHERE entry_id IN (40, 41); UPDATE "
             "chain SET entry_id = CASE entry_id WHEN -40 THEN 41 ELSE 40 END WHERE "
             "entry_id < 0"));
  EXPECT_FALSE(verified().intact());
  ASSERT_TRUE(change("DELETE FROM chain WHERE entry_id = 50"));
  EXPECT_EQ(verified().first.front(), "entry 50 of the chain is missing");
}

// The checker of another hand agrees on the head, and on a change.
TEST_F(ChangedRecord, IsJudgedTheSameByACheckerOfAnotherHand) {
  const auto says = [this] {
    const std::string command =
        "python3 " DRIFTWISE_SOURCE_DIR "/clients/examples/python/check_chain.py " + path;
    std::FILE* pipe = popen(command.c_str(), "r");
    std::string text;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
    pclose(pipe);
    return text;
  };
  EXPECT_THAT(says(), testing::StartsWith("thinned: 60 readings of "));
  EXPECT_THAT(says(), testing::EndsWith("\n" + to_string(verified().head) + "\n"));
  ASSERT_TRUE(change("UPDATE point_value SET value = value + 1e-9 WHERE point_id = 3"));
  EXPECT_THAT(says(), testing::StartsWith("point with key 0103 differs\n"));
}

}  // namespace
}  // namespace driftwise::storage
