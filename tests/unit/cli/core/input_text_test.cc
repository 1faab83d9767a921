// A file given to a command may be a pipe: a second opening of it would wait for a writer that
// has gone, or drop what was written between the two.

#include "clients/cli/core/input_text.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <future>

#include "tests/support/process.h"

namespace driftwise::tests {
namespace {

// Of one file, by whoever had opened it for reading, since this began.
class Closings {
 public:
  explicit Closings(const std::string& path) : events_(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
    ::inotify_add_watch(events_, path.c_str(), IN_CLOSE_NOWRITE | IN_OPEN);
  }
  ~Closings() { ::close(events_); }
  Closings(const Closings&) = delete;
  Closings& operator=(const Closings&) = delete;

  int count() const {
    alignas(inotify_event) std::array<char, 4096> buffer{};
    const auto bytes = ::read(events_, buffer.data(), buffer.size());
    int closings = 0;
    for (ssize_t at = 0; at < bytes;) {
      const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
      closings += (event->mask & IN_CLOSE_NOWRITE) != 0 ? 1 : 0;
      at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
    }
    return closings;
  }

 private:
  int events_;
};

TEST(InputText, OpensAPipeOnce) {
  const TemporaryFolder folder;
  const std::string pipe = folder.path() + "/pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const Closings closings(pipe);
  auto read =
      std::async(std::launch::async, [&] { return std::string(cli::InputText(pipe).text()); });
  const int writer = ::open(pipe.c_str(), O_WRONLY | O_CLOEXEC);
  ASSERT_GE(writer, 0);
  EXPECT_EQ(::write(writer, "q,x\n", 4), 4);
  ::close(writer);
  EXPECT_EQ(read.get(), "q,x\n");
  EXPECT_EQ(closings.count(), 1);
}

}  // namespace
}  // namespace driftwise::tests
