#include "server/application/upkeep/backups.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

namespace fs = std::filesystem;
constexpr double kTryAgain_s = 3600;
constexpr double kSilent_s = 600;  // a disk that wakes up, or a server that starts anew, is sooner
constexpr const char* kPattern = "dddddddd-dddddd";  // of the instant in a name
constexpr std::size_t kInstantLength = 15;
constexpr const char* kUnfinished = ".part";  // of a copy that has no name yet

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

// "20261122-093000"
std::string instant_in(const std::string& path) {
  const std::string name = fs::path(path).stem().string();
  return name.substr(name.size() - kInstantLength);
}

std::size_t kept_count(const BackupRules& rules) {
  return static_cast<std::size_t>(std::max(rules.keep, 1));
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

// A copy of an early program has no identity in its name: the file itself is asked, once.
bool Backups::is_own(Store& store, const std::string& path, const std::string& identity) {
  std::string name = fs::path(path).stem().string();
  if (!name.starts_with(stem())) return false;
  name = name.substr(stem().size());
  if (name.starts_with(identity + "-")) return is_instant(name.substr(identity.size() + 1));
  if (!is_instant(name)) return false;
  auto known = identities_.find(path);
  if (known == identities_.end())
    known = identities_.emplace(path, store.audit().record_in(path)).first;
  return known->second == identity;
}

Result<Backups::Present> Backups::present(Store& store, UtcTime now) {
  Present found;
  DRIFTWISE_TRY(found.identity, store.records().database_id());
  std::error_code failed;  // a folder that cannot be read: the copy itself will say so
  for (fs::directory_iterator entry(folder(), failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const auto path = entry->path().string();
    if (entry->path().extension() == ".db" && is_own(store, path, found.identity))
      found.paths.push_back(path);
  }
  std::ranges::sort(found.paths, {}, instant_in);
  // Made while the clock of the computer was ahead: how old it is cannot be told, so it is the
  // oldest. Else no other one would be due until that instant, and none would be kept beside it.
  std::ranges::stable_partition(
      found.paths, [&](const std::string& path) { return now < instant_of(instant_in(path)); });
  return found;
}

void Backups::remove_parts(Store& store, const std::string& identity) {
  std::vector<fs::path> parts;
  std::error_code failed;
  for (fs::directory_iterator entry(folder(), failed), end; !failed && entry != end;
       entry.increment(failed)) {
    fs::path of = entry->path();  // "<name>.db.part", "<name>.db.part-journal"
    if (!of.extension().string().starts_with(kUnfinished)) continue;
    of.replace_extension();
    if (of.extension() == ".db" && is_own(store, of.string(), identity))
      parts.push_back(entry->path());
  }
  for (const auto& part : parts) {
    fs::remove(part, failed);
    spdlog::info("{} is removed: a copy that was not finished", part.string());
  }
}

// A copy has the pages of the database; its log is not counted, for most of it is there twice.
Result<void> Backups::check_room() const {
  std::error_code failed;
  const auto needed = fs::file_size(database_, failed);
  if (failed) return {};
  const auto space = fs::space(folder(), failed);
  if (failed || space.available >= needed) return {};
  constexpr double kBytesPerMegabyte = 1e6;
  return fail(ErrorCode::resource_exhausted, reasons::kDiskFull,
              fmt::format("a copy of {} needs {:.0f} MB and the disk of {} has {:.0f} MB: make "
                          "room, keep fewer backups, or put them on another disk",
                          database_, static_cast<double>(needed) / kBytesPerMegabyte, folder(),
                          static_cast<double>(space.available) / kBytesPerMegabyte));
}

bool Backups::is_beside_database() {
  struct stat of_folder {
  }, of_database{};
  if (::stat(database_.c_str(), &of_database) != 0) return false;
  const bool is_made = ::stat(folder().c_str(), &of_folder) == 0;
  // A folder that is not made yet is beside the database, or where its parent is.
  if (!is_made && ::stat(fs::path(folder()).parent_path().c_str(), &of_folder) != 0) return false;
  return of_folder.st_dev == of_database.st_dev;
}

Awaitable<void> Backups::look_at_folder() {
  const auto found = co_await reader_.call([this](Store&) -> Result<bool> {
    looking_since_ns_ = clock_.now().utc.utc_ns;
    const bool is_beside = is_beside_database();
    looking_since_ns_ = 0;
    return is_beside;
  });
  if (found) beside_database_ = *found;
}

std::optional<Backups::OnDisk> Backups::on_disk_of_database() const {
  if (!beside_database_) return std::nullopt;
  OnDisk found;
  if (!*beside_database_) return found;
  if (rules_.every_h > 0)
    found.to_come = {kept_count(rules_) + 1 - std::min(present_, kept_count(rules_)),
                     rules_.every_h};
  std::error_code failed;
  for (fs::directory_iterator entry(folder(), failed), end; !failed && entry != end;
       entry.increment(failed)) {
    std::error_code gone;
    const auto bytes = entry->file_size(gone);
    if (!gone) found.bytes += static_cast<std::int64_t>(bytes);
  }
  return found;
}

Awaitable<void> Backups::remove_unfinished() {
  // The next copy tries it again.
  static_cast<void>(co_await reader_.call([this](Store& store) -> Result<void> {
    DRIFTWISE_TRY(const auto identity, store.records().database_id());
    remove_parts(store, identity);
    return {};
  }));
}

Awaitable<Result<RecordCopy>> Backups::make(const Caller* by) {
  if (under_way_)
    co_return fail(ErrorCode::failed_precondition, reasons::kBackupUnderWay,
                   "a backup is being made: ask again when it is done");
  const UnderWay under_way(under_way_);
  const Caller caller = by ? *by : Caller{};
  const bool asked = by != nullptr;
  const auto copied = co_await reader_.call(
      [this](Store& store, UtcTime now) -> Result<RecordCopy> {
        DRIFTWISE_TRY(const auto identity, store.records().database_id());
        const auto target =
            (fs::path(folder()) / (stem() + identity + "-" + instant_text(now) + ".db")).string();
        std::error_code failed;
        fs::create_directories(folder(), failed);
        if (failed)
          return fail(ErrorCode::not_found, reasons::kCannotOpen,
                      fmt::format("the folder of backups, {}, cannot be made: {}", folder(),
                                  failed.message()));
        remove_parts(store, identity);
        DRIFTWISE_RETURN_IF_ERROR(check_room());
        DRIFTWISE_TRY(auto copy, store.audit().back_up(target, gives_way_));
        std::ofstream(fs::path(target).replace_extension(".head")) << to_string(copy.head) << '\n';
        return copy;
      },
      utc_now());
  DRIFTWISE_CO_TRY(auto copy, copied);
  const auto detail =
      fmt::format("{} holds {} rows, {:.1f} MB, checked; chain {}", copy.path, copy.rows,
                  static_cast<double>(copy.bytes) / 1e6, to_string(copy.head));
  if (asked)
    events_.record(caller, "backup.made", detail, {}, {"record", "", copy.path});
  else
    events_.record_own("backup.made", detail);
  failed_.clear();
  const auto removed = co_await reader_.call(
      [this](Store& store, UtcTime now) -> Result<std::vector<std::string>> {
        return remove_oldest(store, now);
      },
      utc_now());
  if (removed)
    for (const auto& path : *removed)
      events_.record_own("backup.removed",
                         fmt::format("{}: the newest {} are kept", path, kept_count(rules_)));
  co_return copy;
}

std::vector<std::string> Backups::remove_oldest(Store& store, UtcTime now) {
  std::vector<std::string> removed;
  const auto found = present(store, now);
  if (!found) return removed;
  const auto& paths = found->paths;
  for (std::size_t i = 0; i + kept_count(rules_) < paths.size(); ++i) {
    std::error_code failed;
    fs::remove(paths[i], failed);
    fs::remove(fs::path(paths[i]).replace_extension(".head"), failed);
    removed.push_back(paths[i]);
  }
  return removed;
}

Awaitable<void> Backups::make_if_due() {
  const auto now = clock_.now().utc;
  if (rules_.every_h <= 0 || under_way_ || now < next_try_) co_return;
  const auto found = co_await reader_.call(
      [this](Store& store, UtcTime utc) -> Result<Present> { return present(store, utc); },
      utc_now());
  if (found) present_ = found->paths.size();
  if (found && !found->paths.empty()) {
    const auto made = instant_of(instant_in(found->paths.back()));
    const bool is_before_now = !(clock_.utc(now) < made);
    if (is_before_now && seconds_from(now - clock_.cell_time(made)) < rules_.every_h * 3600)
      co_return;
  }
  if (under_way_) co_return;  // begun meanwhile
  const auto made = co_await make(nullptr);
  if (made) co_return;
  next_try_ = now + nanoseconds_from_s(kTryAgain_s);
  failed_ =
      fmt::format("no backup was made: {}; it is tried again every hour", made.error().message);
  spdlog::warn("{}", failed_);
}

std::vector<AlarmCondition> Backups::conditions() const {
  std::string told = failed_;
  const CellTime since{looking_since_ns_.load()};
  if (const double silent_s = seconds_from(clock_.now().utc - since);
      since.utc_ns != 0 && silent_s > kSilent_s)
    told = fmt::format(
        "the folder of backups, {}, has not answered for {:.0f} min: no backup is made until it "
        "does; look at the disk or the server that it is on",
        folder(), silent_s / 60);
  if (told.empty()) return {};
  return {{AlarmLevel::warning, "backup.failed", "database", std::move(told)}};
}

}  // namespace driftwise::application
