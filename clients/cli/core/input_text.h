#pragma once
// A file's text for reading: mapped where it is a regular file, so that gigabytes are neither
// copied nor held twice, else read whole (standard input as "-", a pipe). Whoever cuts a mapped
// file short meanwhile ends this process.

#include <string>
#include <string_view>

namespace driftwise::cli {

class InputText {
 public:
  // Throws Failure as read_input_file() does.
  explicit InputText(const std::string& path);
  ~InputText();
  InputText(const InputText&) = delete;
  InputText& operator=(const InputText&) = delete;

  std::string_view text() const;

 private:
  void* mapped_ = nullptr;
  std::size_t size_ = 0;
  std::string read_;
};

}  // namespace driftwise::cli
