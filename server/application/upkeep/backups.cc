#include "server/application/upkeep/backups.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

namespace fs = std::filesystem;
constexpr double kTryAgain_s = 3600;
constexpr const char* kPattern = "dddddddd-dddddd";  // of the instant in a name

// "20261122-093000"
std::string instant_text(UtcTime utc) {
  std::string text = to_iso8601(utc).substr(0, 19);
  std::erase_if(text, [](char c) { return c == '-' || c == ':'; });
  std::ranges::replace(text, 'T', '-');
  return text;
}

bool is_instant(const std::string& text) {
  const std::string pattern = kPattern;
  return text.size() == pattern.size() &&
         std::ranges::equal(text, pattern, [](char found, char wanted) {
           return wanted == 'd' ? found >= '0' && found <= '9' : found == wanted;
         });
}

UtcTime instant_of(const std::string& text) {
  const auto part = [&text](std::size_t at, std::size_t length) { return text.substr(at, length); };
  const auto parsed = parse_iso8601(part(0, 4) + "-" + part(4, 2) + "-" + part(6, 2) + "T" +
                                    part(9, 2) + ":" + part(11, 2) + ":" + part(13, 2) + "Z");
  return {parsed ? parsed->utc_ns : 0};
}

// Set while it lives, also where an exception ends the work.
class UnderWay {
 public:
  explicit UnderWay(bool& flag) : flag_(flag) { flag_ = true; }
  ~UnderWay() { flag_ = false; }
  UnderWay(const UnderWay&) = delete;
  UnderWay& operator=(const UnderWay&) = delete;

 private:
  bool& flag_;
};

}  // namespace

Backups::Backups(Clock& clock, std::string database, BackupRules rules, StoreReader& reader,
                 EventLog& events, std::function<bool()> gives_way)
    : clock_(clock),
      database_(std::move(database)),
      rules_(std::move(rules)),
      reader_(reader),
      events_(events),
      gives_way_(std::move(gives_way)) {}

std::string Backups::folder() const {
  if (!rules_.folder.empty()) return rules_.folder;
  return (fs::path(database_).parent_path() / "backups").string();
}

std::string Backups::stem() const { return fs::path(database_).stem().string() + "-"; }

std::vector<std::string> Backups::present() const {
  std::vector<std::string> paths;
  std::error_code failed;  // a folder that cannot be read: the copy itself will say so
  for (fs::directory_iterator entry(folder(), failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const fs::path& path = entry->path();
    const std::string name = path.stem().string();
    if (path.extension() == ".db" && name.starts_with(stem()) &&
        is_instant(name.substr(stem().size())))
      paths.push_back(path.string());
  }
  std::ranges::sort(paths);
  // Made while the clock of the computer was ahead: how old it is cannot be told, so it is the
  // oldest. Else no other one would be due until that instant, and none would be kept beside it.
  const auto now = clock_.utc(clock_.now().utc);
  std::ranges::stable_partition(
      paths, [&](const std::string& path) { return now < instant_of(instant_in(path)); });
  return paths;
}

std::string Backups::instant_in(const std::string& path) const {
  return fs::path(path).stem().string().substr(stem().size());
}

Awaitable<Result<RecordCopy>> Backups::make(const Caller* by) {
  if (under_way_)
    co_return fail(ErrorCode::failed_precondition, reasons::kBackupUnderWay,
                   "a backup is being made: ask again when it is done");
  const UnderWay under_way(under_way_);
  const Caller caller = by ? *by : Caller{};
  const bool asked = by != nullptr;
  const std::string path =
      (fs::path(folder()) / (stem() + instant_text(clock_.utc(clock_.now().utc)) + ".db")).string();
  const auto copied = co_await reader_.call(
      [this](Store& store, const std::string& target) -> Result<RecordCopy> {
        std::error_code failed;
        fs::create_directories(fs::path(target).parent_path(), failed);
        if (failed)
          return fail(ErrorCode::not_found, reasons::kCannotOpen,
                      fmt::format("the folder of backups, {}, cannot be made: {}",
                                  fs::path(target).parent_path().string(), failed.message()));
        DRIFTWISE_TRY(auto copy, store.audit().back_up(target, gives_way_));
        std::ofstream(fs::path(target).replace_extension(".head")) << to_string(copy.head) << '\n';
        return copy;
      },
      path);
  DRIFTWISE_CO_TRY(auto copy, copied);
  const auto detail =
      fmt::format("{} holds {} rows, {:.1f} MB, checked; chain {}", copy.path, copy.rows,
                  static_cast<double>(copy.bytes) / 1e6, to_string(copy.head));
  if (asked)
    events_.record(caller, "backup.made", detail, {}, {"record", "", copy.path});
  else
    events_.record_own("backup.made", detail);
  failed_.clear();
  remove_oldest();
  co_return copy;
}

void Backups::remove_oldest() {
  auto paths = present();
  const auto keep = static_cast<std::size_t>(std::max(rules_.keep, 1));
  for (std::size_t i = 0; i + keep < paths.size(); ++i) {
    std::error_code failed;
    fs::remove(paths[i], failed);
    fs::remove(fs::path(paths[i]).replace_extension(".head"), failed);
    events_.record_own("backup.removed", fmt::format("{}: the newest {} are kept", paths[i], keep));
  }
}

Awaitable<void> Backups::make_if_due() {
  const auto now = clock_.now().utc;
  if (rules_.every_h <= 0 || under_way_ || now < next_try_) co_return;
  const auto paths = present();
  if (!paths.empty()) {
    const auto made = instant_of(instant_in(paths.back()));
    const bool is_before_now = !(clock_.utc(now) < made);
    if (is_before_now && seconds_from(now - clock_.cell_time(made)) < rules_.every_h * 3600)
      co_return;
  }
  const auto made = co_await make(nullptr);
  if (made) co_return;
  next_try_ = now + nanoseconds_from_s(kTryAgain_s);
  failed_ =
      fmt::format("no backup was made: {}; it is tried again every hour", made.error().message);
  spdlog::warn("{}", failed_);
}

std::vector<AlarmCondition> Backups::conditions() const {
  if (failed_.empty()) return {};
  return {{AlarmLevel::warning, "backup.failed", "database", failed_}};
}

}  // namespace driftwise::application
