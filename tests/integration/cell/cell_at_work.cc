#include "tests/integration/cell/cell_at_work.h"

#include <stdexcept>
#include <thread>

#include "tests/integration/cell/peers/tcp_line.h"

namespace driftwise::tests {
namespace {

std::string command_of(const std::vector<std::string>& arguments) {
  std::string command = "driftwise";
  for (const auto& argument : arguments) command += " " + argument;
  return command;
}

}  // namespace

std::string CellAtWork::say(const std::vector<std::string>& arguments) const {
  const auto done = cli(arguments);
  if (done.code != 0)
    throw std::runtime_error(command_of(arguments) + " ended with " + std::to_string(done.code) +
                             ": " + done.err + "\n" + daemon_log());
  return done.out;
}

nlohmann::json CellAtWork::ask(std::vector<std::string> arguments) const {
  arguments.push_back("--json");
  return nlohmann::json::parse(say(arguments));
}

nlohmann::json CellAtWork::refusal(std::vector<std::string> arguments) const {
  arguments.push_back("--json");
  const auto done = cli(arguments);
  auto json = nlohmann::json::parse(done.err, nullptr, false);
  if (!json.is_object() || !json.contains("error"))
    throw std::runtime_error(command_of(arguments) + " ended with " + std::to_string(done.code) +
                             " and no error: " + done.err);
  json["error"]["exit"] = done.code;
  return json["error"];
}

std::string CellAtWork::control(const std::string& line) const {
  auto answer = ask_line(device_address("control"), line);
  if (!answer.starts_with("OK")) throw std::runtime_error(line + ": " + answer);
  return answer;
}

std::string CellAtWork::write(const std::string& name, const std::string& text) const {
  const std::string path = folder() + "/" + name;
  write_file(path, text);
  return path;
}

std::int64_t CellAtWork::start_run(const std::string& trajectory_csv) const {
  return ask({"run", "start", write("trajectory.csv", trajectory_csv)}).at("id");
}

nlohmann::json CellAtWork::run(std::int64_t number) const {
  return ask({"run", "show", std::to_string(number)}).at("run");
}

std::string CellAtWork::state_of(std::int64_t number) const { return run(number).at("state"); }

nlohmann::json CellAtWork::end_of(std::int64_t number) const {
  const auto done =
      cli({"run", "watch", std::to_string(number), "--timeout", "100"}, std::chrono::seconds(120));
  if (done.code != 0 && done.code != 5)
    throw std::runtime_error("run " + std::to_string(number) + " did not end: " + done.err + "\n" +
                             daemon_log());
  return run(number);
}

void CellAtWork::wait_for_points(std::int64_t wanted) const {
  wait_until(std::to_string(wanted) + " points",
             [&] { return count("SELECT count(*) FROM planned_point") >= wanted; });
}

std::int64_t CellAtWork::events(const std::string& what) const {
  return count("SELECT count(*) FROM event WHERE what = '" + what + "'");
}

void wait_until(const std::string& what, const std::function<bool()>& holds,
                std::chrono::milliseconds limit) {
  const auto until = std::chrono::steady_clock::now() + limit;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > until)
      throw std::runtime_error("in vain waited for: " + what);
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
}

std::string campaign(int lines, int per_line) {
  std::string csv = "q1_mm,set,line,zero\n";
  for (int line = 1, row = 0; line <= lines; ++line)
    for (int i = 0; i < per_line; ++i, ++row) {
      const double q_mm = i == 0 ? 0.0 : -3.0 + 6.0 * i / per_line + 0.125 * (line % 3);
      csv += std::to_string(q_mm) + (row % 3 == 2 ? ",validation," : ",calibration,") +
             std::to_string(line) + (i == 0 ? ",1\n" : ",0\n");
    }
  return csv;
}

}  // namespace driftwise::tests
