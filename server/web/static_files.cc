#include "server/web/static_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <optional>

#include "server/web/mime_type.h"
#include "server/web/security_headers.h"

namespace driftwise::web {
namespace {

namespace fs = std::filesystem;

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    if (i + 2 >= text.size()) return std::nullopt;
    const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    out += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return out;
}

// "/assets/a.js" as "assets/a.js"; nothing for what no file of ours is called.
std::optional<std::string> file_name_of(std::string_view path) {
  const auto decoded = percent_decoded(path);
  if (!decoded || decoded->size() > 400 || !decoded->starts_with('/')) return std::nullopt;
  const std::string name = decoded->substr(1);
  for (const char c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == '\\' || c == 0x7F) return std::nullopt;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    if (end == begin || name[begin] == '.') return std::nullopt;  // "..", hidden, or a double slash
    begin = end + 1;
  }
  return name;
}

bool is_inside(const fs::path& file, const fs::path& folder) {
  std::error_code failed;
  const fs::path real = fs::canonical(file, failed);
  if (failed) return false;
  const fs::path base = fs::canonical(folder, failed);
  if (failed) return false;
  return std::mismatch(base.begin(), base.end(), real.begin(), real.end()).first == base.end();
}

bool takes_gzip(std::string_view accept_encoding) {
  const std::size_t at = accept_encoding.find("gzip");
  if (at == std::string_view::npos) return false;
  const std::string_view rest = accept_encoding.substr(at + 4);
  return !rest.starts_with(";q=0") || rest.starts_with(";q=0.");
}

std::string etag_of(const fs::path& file, bool gzip) {
  std::error_code failed;
  const auto size = fs::file_size(file, failed);
  const auto time = fs::last_write_time(file, failed).time_since_epoch().count();
  return fmt::format("\"{:x}-{:x}{}\"", size, static_cast<std::uint64_t>(time), gzip ? "-gz" : "");
}

bool is_among(std::string_view etag, std::string_view if_none_match) {
  return if_none_match == "*" || if_none_match.find(etag) != std::string_view::npos;
}

HttpResponse send(const fs::path& file, const std::string& name, const HttpRequest& request) {
  std::error_code failed;
  const fs::path packed = file.string() + ".gz";
  const bool gzip =
      takes_gzip(request.header("accept-encoding")) && fs::is_regular_file(packed, failed);
  HttpResponse response;
  const std::string etag = etag_of(gzip ? packed : file, gzip);
  response.headers = {{"ETag", etag},
                      {"Vary", "Accept-Encoding"},
                      {"Cache-Control", name.starts_with("assets/") && has_hash_in_name(name)
                                            ? "public, max-age=31536000, immutable"
                                            : "no-cache"}};
  add_security_headers(response);
  if (is_among(etag, request.header("if-none-match"))) {
    response.status = 304;
    return response;
  }
  response.headers.push_back({"Content-Type", std::string(mime_type(name))});
  if (gzip) response.headers.push_back({"Content-Encoding", "gzip"});
  std::ifstream in(gzip ? packed : file, std::ios::binary);
  response.body.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  if (!in.good() && !in.eof()) return plain_answer(500, name + ": cannot be read\n");
  return response;
}

}  // namespace

bool is_view_address(std::string_view path) {
  // Those of clients/web/src/app/views.ts, and the log-in: a view that is opened by its address.
  static constexpr std::array<std::string_view, 17> kViews = {
      "",           "log-in",        "now",          "instruments",
      "manual",     "commissioning", "trajectories", "runs",
      "queue",      "models",        "plans",        "procedure",
      "diagnosis",  "targets",       "lookback",     "record",
      "indentation"};
  if (!path.starts_with('/')) return false;
  const std::string_view first = path.substr(1, path.find('/', 1) - 1);
  return std::find(kViews.begin(), kViews.end(), first) != kViews.end() &&
         (!first.empty() || path == "/");
}

bool has_hash_in_name(std::string_view file_name) {
  const std::size_t slash = file_name.rfind('/');
  const std::string_view base =
      slash == std::string_view::npos ? file_name : file_name.substr(slash + 1);
  const std::size_t dash = base.find('-');
  const std::size_t dot = base.find('.', dash == std::string_view::npos ? 0 : dash);
  // vite's hashes hold '-' and '_' too: everything between the first dash and the ending counts.
  return dash != std::string_view::npos && dot != std::string_view::npos && dot - dash - 1 >= 8;
}

HttpResponse StaticFiles::answer(const HttpRequest& request) const {
  std::error_code failed;
  const bool is_view = is_view_address(request.path());
  if (is_view && (root_.empty() || !fs::is_regular_file(root_ / "index.html", failed)))
    return plain_answer(
        404, "the web page is not installed" +
                 (root_.empty() ? std::string() : " in " + root_.string()) +
                 ": build clients/web, or name its folder with --web-root or [web] root\n");
  const std::optional<std::string> name =
      is_view ? std::string("index.html") : file_name_of(request.path());
  if (!name) return plain_answer(404, "nothing here\n");
  const fs::path file = root_ / *name;
  if (root_.empty() || !fs::is_regular_file(file, failed) || !is_inside(file, root_))
    return plain_answer(404, "nothing here; there are /, /healthz and /metrics\n");
  return send(file, *name, request);
}

}  // namespace driftwise::web
