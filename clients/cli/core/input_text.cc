#include "clients/cli/core/input_text.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

namespace {

// A pipe is opened once only, by whoever reads it: its writer may go when the first reader does.
int open_regular_file(const std::string& path) {
  struct stat about {};
  if (path == "-" || ::stat(path.c_str(), &about) != 0 || !S_ISREG(about.st_mode)) return -1;
  return ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
}

}  // namespace

InputText::InputText(const std::string& path) {
  const int file = open_regular_file(path);
  struct stat about {};
  if (file >= 0 && ::fstat(file, &about) == 0 && S_ISREG(about.st_mode) && about.st_size > 0) {
    const auto size = static_cast<std::size_t>(about.st_size);
    void* mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
    if (mapped != MAP_FAILED) {
      mapped_ = mapped;
      size_ = size;
    }
  }
  if (file >= 0) ::close(file);
  if (mapped_ == nullptr) read_ = read_input_file(path);
}

InputText::~InputText() {
  if (mapped_ != nullptr) ::munmap(mapped_, size_);
}

std::string_view InputText::text() const {
  return mapped_ != nullptr ? std::string_view(static_cast<const char*>(mapped_), size_) : read_;
}

}  // namespace driftwise::cli
