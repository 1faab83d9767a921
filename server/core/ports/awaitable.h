#pragma once
// The ports are coroutines on one executor thread; this is the only Asio name they need.
// CMake target driftwise_ports: application, drivers and storage link it, the mathematics does not.

#include <boost/asio/awaitable.hpp>

namespace driftwise {
namespace asio = boost::asio;
template <class T>
using Awaitable = boost::asio::awaitable<T>;
}  // namespace driftwise
