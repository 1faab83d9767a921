// The functions of Asio's TLS, compiled once, as those of server/core/ports/asio_impl.cc.

#include <boost/asio/ssl/impl/src.hpp>
