#include "server/formats/cell_file/without_secrets.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

bool names_a_secret(std::string_view key) {
  const std::string name = lower(key);
  for (const char* word : {"password", "passwd", "secret", "token", "passphrase", "credential"})
    if (name.find(word) != std::string::npos) return true;
  return name == "command" || name == "key" || name.ends_with("_key");
}

// Of people: hidden where it stands, and no secret.
bool names_a_person(std::string_view key) { return key == "user" || key == "from" || key == "to"; }

bool is_file_key(std::string_view key) {
  return key.ends_with("_file") || key == "key" || key == "certificate" || key == "authority" ||
         key == "revoked";
}

bool is_address(std::string_view value) { return value.find("://") != std::string_view::npos; }

// "https://[removed]@host/[removed]": whatever is not scheme and host is often a secret.
std::string host_alone(std::string_view url) {
  const auto begin = url.find("://") + 3;
  const auto end = std::min(url.find_first_of("/?#", begin), url.size());
  std::string_view host = url.substr(begin, end - begin);
  if (const auto at = host.rfind('@'); at != std::string_view::npos) host = host.substr(at + 1);
  return std::string(url.substr(0, begin)) + std::string(host) +
         (end + 1 < url.size() ? "/" + std::string(kRemoved) : std::string(url.substr(end)));
}

// A key as TOML has it: quoted where it is not bare.
std::string key_text(std::string_view key) {
  const bool bare = !key.empty() && std::ranges::all_of(key, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  });
  if (bare) return std::string(key);
  std::ostringstream out;
  out << toml::value<std::string>(std::string(key));
  return out.str();
}

struct Walk {
  std::ostringstream out;
  std::vector<std::string> secrets;

  void note(std::string_view value) {
    if (value.size() >= 4) secrets.emplace_back(value);
  }

  void quoted(std::string_view text) {
    if (text.find_first_of("\"\\\n\r\t") == std::string_view::npos)
      out << '"' << text << '"';
    else
      out << toml::value<std::string>(std::string(text));
  }

  void note_all(const toml::node& node) {
    if (const auto* text = node.as_string()) note(text->get());
    if (const auto* list = node.as_array())
      for (const auto& one : *list) note_all(one);
    if (const auto* table = node.as_table())
      for (const auto& [key, one] : *table) note_all(one);
  }

  void value(std::string_view key, const toml::node& node) {
    const auto* text = node.as_string();
    if (is_file_key(key) && text != nullptr) {
      const std::string& path = text->get();
      quoted(path.substr(path.rfind('/') == std::string::npos ? 0 : path.rfind('/') + 1));
    } else if (names_a_person(key)) {
      out << '"' << kRemoved << '"';
    } else if (names_a_secret(key)) {
      note_all(node);
      out << '"' << kRemoved << '"';
    } else if (text != nullptr && is_address(text->get())) {
      const std::string& url = text->get();
      const std::string shown = host_alone(url);
      if (shown != url) {
        note(url);
        const auto begin = url.find("://") + 3;
        const auto end = url.find_first_of("/?#", begin);
        if (end != std::string::npos) note(std::string_view(url).substr(end));
        if (const auto at = url.find('@', begin); at != std::string::npos)
          note(std::string_view(url).substr(begin, at - begin));
      }
      quoted(shown);
    } else if (const auto* list = node.as_array()) {
      out << '[';
      bool first = true;
      for (const auto& one : *list) {
        if (!first) out << ", ";
        first = false;
        value(key, one);
      }
      out << ']';
    } else if (const auto* table = node.as_table()) {
      out << '{';
      bool first = true;
      for (const auto& [name, one] : *table) {
        out << (first ? " " : ", ") << key_text(name.str()) << " = ";
        first = false;
        value(name.str(), one);
      }
      out << " }";
    } else {
      node.visit([this](const auto& plain) { out << plain; });
    }
  }

  void table(const std::string& place, const toml::table& table) {
    for (const auto& [key, node] : table) {
      const bool is_tables = node.is_table() || (node.is_array_of_tables());
      if (is_tables && key.str() != "options") continue;
      out << key_text(key.str()) << " = ";
      value(key.str(), node);
      out << '\n';
    }
    for (const auto& [key, node] : table) {
      const std::string under =
          place.empty() ? key_text(key.str()) : place + "." + key_text(key.str());
      if (key.str() == "options") continue;
      if (const auto* inner = node.as_table()) {
        out << "\n[" << under << "]\n";
        this->table(under, *inner);
      } else if (node.is_array_of_tables()) {
        for (const auto& one : *node.as_array()) {
          out << "\n[[" << under << "]]\n";
          this->table(under, *one.as_table());
        }
      }
    }
  }
};

Walk walked(std::string_view text) {
  Walk walk;
  try {
    walk.table("", parse_toml(text));
  } catch (const toml::parse_error& error) {
    walk.out.str("");
    walk.out << "# the cell file cannot be read as TOML: " << error.description() << '\n';
  }
  return walk;
}

void replace_all(std::string& text, const std::string& found) {
  for (std::size_t at = text.find(found); at != std::string::npos;
       at = text.find(found, at + kRemoved.size()))
    text.replace(at, found.size(), kRemoved);
}

bool ends_value(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0 || c == '"' || c == '\'' || c == ',' ||
         c == ';' || c == '&' || c == '}' || c == ')' || c == ']';
}

// What follows the word, up to a blank or a quote. min: fewer bytes are no secret.
void remove_after(std::string& text, std::string_view word, std::size_t min) {
  std::string low = lower(text);
  for (std::size_t at = low.find(word); at != std::string::npos; at = low.find(word, at)) {
    at += word.size();
    std::size_t end = at;
    while (end < text.size() && !ends_value(text[end])) ++end;
    if (end - at < min || text.compare(at, kRemoved.size(), kRemoved) == 0) continue;
    text.replace(at, end - at, kRemoved);
    low.replace(at, end - at, kRemoved);
  }
}

void remove_private_keys(std::string& text) {
  constexpr std::string_view kBegin = "-----BEGIN ", kEnd = "-----END ";
  for (std::size_t at = text.find(kBegin); at != std::string::npos;
       at = text.find(kBegin, at + 1)) {
    if (text.substr(at, 64).find("PRIVATE KEY") == std::string::npos) continue;
    auto end = text.find(kEnd, at);
    end = end == std::string::npos ? text.size()
                                   : std::min(text.size(), text.find("-----", end + 9) + 5);
    text.replace(at, end - at, kRemoved);
  }
}

void remove_users_of_addresses(std::string& text) {
  for (std::size_t at = text.find("://"); at != std::string::npos; at = text.find("://", at + 3)) {
    std::size_t end = at + 3;
    while (end < text.size() && text[end] != '/' && !ends_value(text[end])) ++end;
    const auto sign = text.rfind('@', end);
    if (sign == std::string::npos || sign <= at + 3 || sign > end) continue;
    text.replace(at + 3, sign - at - 3, kRemoved);
  }
}

// Paths and queries of every address in a text.
void cut_addresses(std::string& text) {
  for (std::size_t at = text.find("://"); at != std::string::npos; at = text.find("://", at + 3)) {
    std::size_t end = at + 3;
    if (end < text.size() && text[end] == '[') end = std::min(text.find(']', end), text.size());
    if (end < text.size() && text[end] == ']') ++end;
    const std::size_t host_end = std::min(text.find_first_of("/?#", end), text.size());
    while (end < text.size() && !ends_value(text[end])) ++end;
    if (host_end + 1 >= end || text.compare(host_end + 1, kRemoved.size(), kRemoved) == 0) continue;
    text.replace(host_end, end - host_end, "/" + std::string(kRemoved));
  }
}

// A key of the text names a secret, and its value is still there. Keys are the first words of
// "name duty, webhook https://..." and of "{token = a, units = K}", and those after a comma.
bool mentions_a_secret(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_of(" ,{}", at), text.size());
    const std::string_view key = text.substr(at, end - at), after = text.substr(end);
    if (!is_file_key(key) && names_a_secret(key) && !after.starts_with(" " + std::string(kRemoved)))
      return true;
    const std::size_t next = text.find_first_of(",{", at);
    if (next == std::string_view::npos) break;
    at = std::min(text.find_first_not_of(" ,{", next), text.size());
  }
  return false;
}

}  // namespace

std::string value_without_secrets(std::string_view key, std::string value) {
  if (value.empty()) return value;
  const auto dot = key.rfind('.');
  const std::string_view name = dot == std::string_view::npos ? key : key.substr(dot + 1);
  if (!name.empty() && !is_file_key(name) && names_a_secret(name)) return std::string(kRemoved);
  const bool lists_keys = name.empty() || value.find('{') != std::string::npos;
  if (lists_keys && mentions_a_secret(value)) return std::string(kRemoved);
  const bool is_one_address =
      !name.empty() && is_address(value) && value.find_first_of(" [{") == std::string::npos;
  if (is_one_address) return host_alone(value);
  value = without_secrets(std::move(value), {});
  cut_addresses(value);
  return value;
}

std::string cell_file_without_secrets(std::string_view text) { return walked(text).out.str(); }

std::vector<std::string> secrets_of_cell_file(std::string_view text) {
  return walked(text).secrets;
}

std::string without_secrets(std::string text, const std::vector<std::string>& known) {
  constexpr std::size_t kShortest = 4;
  // Long ones first: a short one may be a part of them.
  std::vector<std::string> values = known;
  std::ranges::sort(values, [](const auto& a, const auto& b) { return a.size() > b.size(); });
  for (const auto& value : values)
    if (value.size() >= kShortest && value != "/") replace_all(text, value);
  remove_private_keys(text);
  remove_users_of_addresses(text);
  remove_after(text, "dwt_", 8);
  remove_after(text, "bearer ", 4);
  for (const char* word :
       {"password=", "password: ", "passwd=", "secret=", "token=", "api_key=", "passphrase="})
    remove_after(text, word, 1);
  return text;
}

}  // namespace driftwise::formats
