// Settings of a serial line on a pseudo-terminal, whose two sides share them.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <termios.h>
#include <unistd.h>

#include <array>

#include "drivers/transport/byte_stream.h"
#include "tests/support/run_awaitable.h"
#include "tests/unit/drivers/pty_peer.h"

namespace driftwise::transport {
namespace {

class SerialLine : public testing::TestWithParam<Parity> {
 protected:
  std::unique_ptr<ByteStream> opened() {
    auto stream = make_serial_stream(context.get_executor(), {peer.path()}, {.parity = GetParam()});
    EXPECT_FALSE(tests::run(context, stream->open()));
    return stream;
  }
  asio::io_context context{1};
  tests::PtyPeer peer{[](std::string& received) { return std::exchange(received, {}); }};
};

// termios(3): with INPCK and without IGNPAR and PARMRK a byte with a framing or parity error is
// read as NUL. With IGNPAR it is dropped.
TEST_P(SerialLine, HandsOnADamagedCharacterAsNul) {
  const auto stream = opened();
  const int other = ::open(peer.path().c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GE(other, 0);
  termios line{};
  ASSERT_EQ(::tcgetattr(other, &line), 0);
  ::close(other);
  EXPECT_NE(line.c_iflag & INPCK, 0u);
  EXPECT_EQ(line.c_iflag & IGNPAR, 0u);
  EXPECT_EQ(line.c_iflag & PARMRK, 0u);
  EXPECT_EQ(line.c_iflag & ISTRIP, 0u) << "eight bits";
}

TEST_P(SerialLine, CarriesEveryByteAsItIs) {
  const auto stream = opened();
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all += static_cast<char>(byte);
  EXPECT_FALSE(tests::run(context, stream->write(all)).error);
  std::string back;
  std::array<char, 512> piece{};
  while (back.size() < all.size()) {
    const auto [error, count] = tests::run(context, stream->read_some(piece));
    ASSERT_FALSE(error) << error.message();
    back.append(piece.data(), count);
  }
  EXPECT_EQ(back, all);
}

INSTANTIATE_TEST_SUITE_P(Parities, SerialLine,
                         testing::Values(Parity::none, Parity::even, Parity::odd));

}  // namespace
}  // namespace driftwise::transport
