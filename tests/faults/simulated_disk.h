#pragma once
// What a disk holds after the power fails: for each file the content at its last sync, and the
// writes since, of which any part may have arrived. Pure memory; tests/faults/unsynced_vfs.h feeds
// it.
//
// Thread: none of its own, the caller locks.

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace driftwise::faults {

// Which of the unsynced changes arrived on the disk.
enum class Survivors {
  none,    // the drive's cache was lost whole
  all,     // everything had arrived, only nobody was told
  random,  // sector by sector, in any combination
};

struct PowerCut {
  Survivors survivors = Survivors::none;
  std::uint64_t seed = 0;  // for random: the same seed, the same disk
  std::size_t sector_bytes =
      512;  // a sector arrives whole or not at all; writes are torn at its borders
};

class SimulatedDisk {
 public:
  bool knows(const std::string& path) const { return files_.contains(path); }
  // A file that was there, and on the disk, before anything was recorded.
  void found(const std::string& path, std::string content);

  void created(const std::string& path);
  void removed(const std::string& path);
  void written(const std::string& path, std::uint64_t offset, std::string_view bytes);
  void truncated(const std::string& path, std::uint64_t size);

  void sync_file(const std::string& path);  // its bytes, not its name in the folder
  void sync_folder();                       // names: which files there are

  // path -> content of each file that is there when the power comes back.
  std::map<std::string, std::string> after(const PowerCut& cut) const;

 private:
  struct Change {  // of bytes: a write, or a truncation to offset
    bool truncates;
    std::uint64_t offset;
    std::string bytes;
  };
  struct Body {
    bool exists = false;
    std::string content;           // as of its last sync
    std::vector<Change> unsynced;  // in order
  };
  // A file's bodies since the folder was last synced: the first is the one whose name is on the
  // disk, each creation or removal adds one, the last is the one that programs see. Bytes of a body
  // can be synced before its name is.
  struct File {
    std::vector<Body> bodies = {Body{}};
  };
  static void apply(const Change& change, std::string& content);
  static std::string torn(const Body& body, std::size_t sector_bytes, double chance,
                          std::mt19937_64& random);

  std::map<std::string, File> files_;
};

}  // namespace driftwise::faults
