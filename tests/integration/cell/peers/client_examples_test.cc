// The examples in clients/examples do what their first lines say, built and run as a reader would.

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <thread>

#include "tests/integration/cell/cell_at_work.h"
#include "tests/integration/cell/served_model.h"

namespace driftwise::tests {
namespace {

using std::chrono::minutes;
const std::string kExamples = std::string(DRIFTWISE_SOURCE_DIR) + "/clients/examples";

void expect_done(const Finished& finished, const std::string& what) {
  ASSERT_EQ(finished.code, 0) << what << "\n" << finished.out << finished.err;
}

TEST(Examples, AControllerBuildsAgainstTheInstalledLibraryAndAsksForATarget) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "an instrumented library does not link with a plain program";
#endif
  const TemporaryFolder folder;
  const std::string prefix = folder.path() + "/prefix", build = folder.path() + "/build";
  expect_done(run_process({"/usr/bin/cmake", "--install", DRIFTWISE_BUILD_FOLDER, "--prefix",
                           prefix, "--component", "development"},
                          minutes(2)),
              "installing");
  expect_done(run_process({"/usr/bin/cmake", "-S", kExamples + "/cpp", "-B", build,
                           "-DCMAKE_PREFIX_PATH=" + prefix, "-DCMAKE_BUILD_TYPE=Debug"},
                          minutes(2)),
              "configuring the example");
  expect_done(run_process({"/usr/bin/cmake", "--build", build}, minutes(4)),
              "building the example");

  CellAtWork cell;
  cell.start_daemon();
  serve_known_model(cell);
  const auto target = run_process({build + "/controller", cell.grpc_address(), "1.5"}, minutes(1));
  expect_done(target, "asking");
  EXPECT_THAT(target.out, testing::MatchesRegex("q1_mm 1\\.[0-9]+ u90_nm [0-9.]+\n(.|\n)*"));
}

// A text line that holds its first answer back until another client connects.
class LateLine {
 public:
  LateLine() {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    bind(listening_, reinterpret_cast<sockaddr*>(&here), size);
    getsockname(listening_, reinterpret_cast<sockaddr*>(&here), &size);
    port_ = ntohs(here.sin_port);
    listen(listening_, 2);
    thread_ = std::thread([this] { answer_late(); });
  }
  ~LateLine() {
    shutdown(listening_, SHUT_RDWR);
    thread_.join();
    close(listening_);
  }
  LateLine(const LateLine&) = delete;
  LateLine& operator=(const LateLine&) = delete;
  int port() const { return port_; }

 private:
  void answer_late() const {
    const int line = accept(listening_, nullptr, nullptr);
    const int other = accept(listening_, nullptr, nullptr);
    for (const int late : {line, other}) {
      const std::string answer = "OK q1_mm=1 flags=-\n";
      (void)send(late, answer.data(), answer.size(), MSG_NOSIGNAL);
    }
    char end = 0;
    while (recv(line, &end, 1, 0) > 0) {  // until the client goes
    }
    for (const int fd : {line, other}) close(fd);
  }
  const int listening_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  int port_ = 0;
  std::thread thread_;
};

// Else every further answer would belong to the question before.
TEST(Examples, OctaveAsksNoMoreOnALineWhoseAnswerIsMissing) {
  const std::string octave = "/usr/bin/octave-cli";
  if (!std::filesystem::exists(octave) ||
      run_process({octave, "--quiet", "--no-init-file", "--eval", "pkg load instrument-control"})
              .code != 0)
    GTEST_SKIP() << "GNU Octave with its package instrument-control is not installed (apt install "
                    "octave octave-instrument-control)";
  const LateLine daemon;
  const std::string connect =
      "tcpclient('127.0.0.1', " + std::to_string(daemon.port()) + ", 'Timeout', ";
  const auto asked = run_process(
      {octave, "--quiet", "--no-init-file", "--eval",
       "addpath('" + kExamples + "/matlab'); pkg load instrument-control; line = " + connect +
           "1); try driftwise_target(line, 'x_mm', 1); catch err, disp(err.identifier), end, "
           "other = " +
           connect +
           "60); read(other, 1); "  // by now the late answer is there
           "try a = driftwise_target(line, 'x_mm', 2); printf('%g\\n', a.q1_mm); catch err, "
           "disp(err.identifier), end"},
      minutes(2));
  expect_done(asked, "octave");
  EXPECT_EQ(asked.out, "driftwise:NO_ANSWER\ndriftwise:CONNECTION_LOST\n");
}

// The digits of [0.5 1], one after the other, are 0.51: another pose.
TEST(Examples, OctaveAsksForNoArray) {
  if (!std::filesystem::exists("/usr/bin/octave-cli"))
    GTEST_SKIP() << "GNU Octave is not installed (apt install octave)";
  const auto asked =
      run_process({"/usr/bin/octave-cli", "--quiet", "--no-init-file", "--eval",
                   "addpath('" + kExamples +
                       "/matlab'); try, driftwise_target(0, 'x_mm', [0.5 1]); catch err, "
                       "disp(err.identifier), end, try, driftwise_target(0, 'x_mm'); catch err, "
                       "disp(err.identifier), end"},
                  minutes(2));
  expect_done(asked, "octave");
  EXPECT_EQ(asked.out, "driftwise:BAD_NUMBER\ndriftwise:BAD_NUMBER\n");
}

// Rows of q1 = x + 0.001 (t05 - 20) in mm, among them passages without a pose and a point whose
// beam was broken, which a person took out.
std::string rows_with_passages() {
  std::ostringstream csv;
  csv << std::setprecision(17) << "time_s,set,excluded,passage,q1_mm,x_mm,t05_degC\n";
  for (int i = 0; i < 60; ++i) {
    const bool is_passage = i % 10 == 0, is_broken = i == 33;
    const double x_mm = (i * 37 % 60 - 30) / 10.0, t_degc = 17 + i / 10.0;
    const double q_mm = x_mm + 0.001 * (t_degc - 20) + (i % 2 == 0 ? 1e-6 : -1e-6);
    csv << 10 * i << (i % 3 == 2 ? ",validation," : ",calibration,")
        << (is_passage || is_broken ? "1," : "0,") << (is_passage ? "1," : "0,") << q_mm << ',';
    if (!is_passage) csv << (is_broken ? 99 : x_mm);
    csv << ',' << t_degc << '\n';
  }
  return csv.str();
}

// The line of the manual that says which rows: "%   cal = t.in_use & ...".
std::string documented_choice_of_rows() {
  std::ifstream file(kExamples + "/matlab/read_dataset.m");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("%   cal = ")) return line.substr(1);
  return "error('read_dataset.m does not say which rows to fit');";
}

TEST(Examples, OctaveReadsAnExportedDatasetAndFitsWhatDriftwiseFits) {
  if (!std::filesystem::exists("/usr/bin/octave-cli"))
    GTEST_SKIP() << "GNU Octave is not installed (apt install octave)";
  CellAtWork cell;
  cell.start_daemon();
  const auto run =
      cell.ask({"data", "import", cell.write("passages.csv", rows_with_passages())}).at("id");
  const std::string csv = cell.folder() + "/exported.csv";
  cell.say({"data", "export", std::to_string(run.get<int>()), "-o", csv});
  const auto fit = cell.ask({"fit", csv, "--model", "q ~ x + t05", "--select", "all"});
  const auto octave = run_process(
      {"/usr/bin/octave-cli", "--quiet", "--no-init-file", "--eval",
       "addpath('" + kExamples + "/matlab'); t = read_dataset('" + csv + "'); " +
           documented_choice_of_rows() +
           " printf('%d\\n', sum(cal)); b = [ones(sum(cal), 1), t.x_mm(cal), t.t05_degC(cal)] "
           "\\ t.q1_mm(cal); printf('%.12g\\n', b);"},
      minutes(2));
  expect_done(octave, "octave");
  std::istringstream lines(octave.out);
  int rows = 0;
  lines >> rows;
  EXPECT_EQ(rows, 35) << "of 60: 20 validate, 4 of the others are passages, one is taken out";
  for (const char* term : {"1", "x", "t05"}) {
    double theirs = 0;
    ASSERT_TRUE(lines >> theirs) << octave.out;
    for (const auto& one : fit.at("outputs").at("q1").at("terms"))
      if (one.at("term") == term) {
        EXPECT_NEAR(one.at("coefficient").get<double>(), theirs, 1e-9) << term;
      }
  }
}

}  // namespace
}  // namespace driftwise::tests
