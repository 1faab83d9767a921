#pragma once
// A cell with a queue on virtual time.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "server/application/queue/queue.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
using application::QueueDraft;
using application::QueueLine;

inline const std::string kShort = lines_of(1, {1, -2}, true);

inline QueueDraft draft(const std::string& name) {
  QueueDraft d;
  d.name = name;
  d.trajectory_name = name + ".csv";
  d.trajectory_text = kShort;
  return d;
}

// Declared by the interferometer, which never gives it.
inline CellDescription with_pressure(CellDescription cell) {
  for (auto& device : cell.devices)
    if (device.length()) device.channels.push_back({"pressure", "hPa"});
  return cell;
}

class QueueTest : public testing::Test {
 protected:
  explicit QueueTest(OpenStore open_store = kSqlite)
      : cell(world, with_pressure(small_cell(folder / "cell.sqlite")), std::move(open_store)) {}

  QueueLine add(QueueDraft d) {
    auto line = cell.await(cell->queue.add(cell.ada, std::move(d)));
    if (!line) throw std::runtime_error(line.error().message);
    return *line;
  }
  QueueEntry look(const QueueLine& line) { return cell->queue.get(line.entry.id)->entry; }
  QueueState state_of(const QueueLine& line) { return look(line).state; }
  std::string waits_for(const QueueLine& line) { return cell->queue.get(line.entry.id)->waits_for; }
  void until(const QueueLine& line, QueueState state) {
    cell.until([&] { return state_of(line) == state; });
  }
  void write_template() {
    std::ofstream(folder / "report.html")
        << "<script type=\"application/json\" id=\"report-data\">null</script>";
  }
  static nlohmann::json report_in(const std::string& path) {
    std::ifstream file(path);
    const std::string page{std::istreambuf_iterator<char>(file), {}};
    const auto begin = page.find('{');
    return nlohmann::json::parse(page.substr(begin, page.find("</script>") - begin));
  }
  QueueHold hold() { return cell->queue.list().hold; }
  void release() { ASSERT_TRUE(cell.await(cell->queue.release(cell.ada))); }
  void give_up_lease(const std::string& token) {
    ASSERT_TRUE(cell->manual.give_up_lease(cell.ada, token));
  }
  std::vector<std::string> names_of_runs() {  // oldest first
    std::vector<std::string> names;
    const auto runs = cell.await(cell.runs(0, 0));
    for (const auto& run : *runs) names.insert(names.begin(), run.name);
    return names;
  }

  Folder folder;
  SmallWorld world;
  CellInMemory cell;
};

}  // namespace driftwise::tests
