#pragma once
// The files of the web page: a folder, read as it is at each request (they are small, and a page
// rebuilt while the daemon runs is served at once).
//
// A file of assets/ whose name carries a hash never changes and may be kept for ever; others are
// asked for again with their ETag. file.gz beside a file is sent to who takes gzip. A view's
// address
// (/, /now, /runs/17, ...) is answered with index.html. Nothing outside the folder is served,
// whether by "..", by percent signs or by a link; names that begin with a dot are not served.
//
// Thread: any one; a request costs a stat and a read.

#include <filesystem>
#include <string>
#include <string_view>

#include "server/web/http_message.h"

namespace driftwise::web {

// Of the page's own addresses: the first part of the path names a view.
bool is_view_address(std::string_view path);

// "assets/index-BWqQ7d2x.js": a hash of at least eight characters before the ending.
bool has_hash_in_name(std::string_view file_name);

class StaticFiles {
 public:
  // root: the folder with index.html; empty or missing: every answer says how to get one.
  explicit StaticFiles(std::filesystem::path root) : root_(std::move(root)) {}

  // GET and HEAD; the body is there for both.
  HttpResponse answer(const HttpRequest& request) const;

 private:
  std::filesystem::path root_;
};

}  // namespace driftwise::web
