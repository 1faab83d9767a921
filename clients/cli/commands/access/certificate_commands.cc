#include "clients/cli/commands/access/certificate_commands.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>

#include "clients/cli/commands/access/role_text.h"
#include "clients/cli/core/validators.h"
#include "storage/sqlite/file_owner.h"

extern char** environ;

namespace driftwise::cli {
namespace {

namespace fs = std::filesystem;

struct CertificateArguments {
  std::string folder = "tls", name, role;
  std::vector<std::string> names;
  double days = 0;
};

constexpr double kAuthorityDays = 3650, kServerDays = 825, kClientDays = 365;

Failure cannot(const std::string& what, const std::string& why) {
  return {ExitCode::refused, "failed_precondition", "NO_CERTIFICATE", what + ": " + why};
}

// A file that goes with its holder.
class Scratch {
 public:
  explicit Scratch(fs::path path) : path_(std::move(path)) {}
  ~Scratch() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

// openssl(1) with these arguments, no shell between: what it says, which is in the message of a
// failure too.
std::string openssl(const fs::path& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "openssl");
  std::vector<char*> pointers;
  for (auto& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const Scratch said(folder / ".openssl.said");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, said.path().c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t process = 0;
  const int failed =
      ::posix_spawnp(&process, "openssl", &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0)
    throw cannot("openssl cannot be executed",
                 std::string(std::strerror(failed)) + ": install it (Debian: apt install openssl)");
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  std::ifstream file(said.path());
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return text;
  throw cannot("openssl " + arguments.at(1) + " failed", text.substr(0, 600));
}

void make_folder(const fs::path& folder) {
  std::error_code failed;
  if (fs::is_directory(folder, failed)) return;
  fs::create_directories(folder, failed);
  if (!failed) fs::permissions(folder, fs::perms::owner_all, failed);
  storage::give_to_owner_of_folder(folder.string());
  if (failed)
    throw Failure{ExitCode::bad_input, "invalid_argument", "CANNOT_WRITE",
                  "cannot make " + folder.string() + ": " + failed.message()};
}

void rename_file(const std::string& from, const fs::path& to) {
  std::error_code failed;
  fs::rename(from, to, failed);
  if (failed)
    throw Failure{ExitCode::bad_input, "invalid_argument", "CANNOT_WRITE",
                  "cannot write " + to.string() + ": " + failed.message()};
}

bool is_address(const std::string& text) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  return ::inet_pton(AF_INET, text.c_str(), bytes.data()) == 1 ||
         ::inet_pton(AF_INET6, text.c_str(), bytes.data()) == 1;
}

// What may stand in a file name, a subject and a configuration of openssl without a meaning there.
void check_plain(const std::string& text, const char* what, const char* further) {
  const bool good =
      !text.empty() && text.size() <= 60 && text.front() != '-' && text.front() != '.' &&
      text.find_first_not_of(
          std::string("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.") +
          further) == std::string::npos;
  if (!good)
    throw Failure{ExitCode::bad_input, "invalid_argument", "BAD_NAME",
                  std::string(what) + ": found '" + text +
                      "', expected 1 to 60 letters, digits, '-', '_' and '.'"};
}

std::string days_text(double asked, double usual) {
  return std::to_string(static_cast<int>(std::ceil(asked > 0 ? asked : usual)));
}

const std::vector<std::string> kNewKey = {"-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
                                          "-nodes"};

std::vector<std::string> with_new_key(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), kNewKey.begin(), kNewKey.end());
  return arguments;
}

// Reader of a certificate's files: the daemon, as the owner of the folder, or the person for
// whom they are made.
enum class For { daemon, client };

// folder/stem.key and folder/stem.pem, signed by the folder's authority; the key is there first, so
// that a daemon that looks between the two waits for the certificate.
void sign(For whom, const fs::path& folder, const std::string& stem, const std::string& subject,
          const std::string& use, const std::string& alternative_names, const std::string& days) {
  const Scratch key(folder / ("." + stem + ".key")), request(folder / ("." + stem + ".csr")),
      certificate(folder / ("." + stem + ".pem")), extensions(folder / ("." + stem + ".cnf"));
  std::ofstream(extensions.path())
      << "basicConstraints = critical, CA:FALSE\nkeyUsage = critical, digitalSignature\n"
      << "extendedKeyUsage = " << use << "\nsubjectAltName = " << alternative_names << '\n';
  openssl(folder, with_new_key({"req", "-new", "-keyout", key.path(), "-out", request.path(),
                                "-subj", "/CN=" + subject}));
  openssl(folder,
          {"x509", "-req", "-in", request.path(), "-CA", (folder / "authority.pem").string(),
           "-CAkey", (folder / "authority.key").string(), "-CAcreateserial", "-CAserial",
           (folder / "authority.srl").string(), "-days", days, "-sha256", "-extfile",
           extensions.path(), "-out", certificate.path()});
  if (whom == For::daemon)
    for (const Scratch* made : {&key, &certificate}) storage::give_to_owner_of_folder(made->path());
  rename_file(key.path(), folder / (stem + ".key"));
  rename_file(certificate.path(), folder / (stem + ".pem"));
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "localhost";
}

// Files that openssl ca(1) needs for a list of revoked certificates.
void write_list_settings(const fs::path& folder, const Scratch& settings) {
  const auto path = [&](const char* name) { return (folder / name).string(); };
  std::ofstream(settings.path())
      << "[ca]\ndefault_ca = own\n[own]\ndatabase = " << path("authority.index")
      << "\ncrlnumber = " << path("authority.crlnumber")
      << "\ncertificate = " << path("authority.pem") << "\nprivate_key = " << path("authority.key")
      << "\ndefault_md = sha256\nunique_subject = no\ndefault_crl_days = "
      << days_text(0, kAuthorityDays) << "\ndefault_days = " << days_text(0, kClientDays) << '\n';
  if (!fs::exists(path("authority.index"))) std::ofstream(path("authority.index"));
  if (!fs::exists(path("authority.crlnumber")))
    std::ofstream(path("authority.crlnumber")) << "01\n";
}

// revoked.pem anew.
void write_revocations(const fs::path& folder) {
  const Scratch settings(folder / ".revoke.cnf"), list(folder / ".revoked.pem");
  write_list_settings(folder, settings);
  openssl(folder, {"ca", "-batch", "-config", settings.path(), "-gencrl", "-out", list.path()});
  storage::give_to_owner_of_folder(list.path());
  rename_file(list.path(), folder / "revoked.pem");
}

// Every certificate that was made for a name is kept here, so that those of before can be revoked.
fs::path folder_of_issued(const fs::path& folder, const std::string& name) {
  return folder / "issued" / name;
}

void keep_issued(const fs::path& folder, const std::string& name) {
  const fs::path kept = folder_of_issued(folder, name);
  make_folder(folder / "issued");
  make_folder(kept);
  int number = 1;
  while (fs::exists(kept / (std::to_string(number) + ".pem"))) ++number;
  std::error_code failed;
  fs::copy_file(folder / (name + ".pem"), kept / (std::to_string(number) + ".pem"), failed);
  if (!failed) return;
  const std::string why = failed.message();
  fs::remove(folder / (name + ".pem"), failed);
  throw Failure{ExitCode::bad_input, "invalid_argument", "CANNOT_WRITE",
                "cannot keep a copy in " + kept.string() + ": " + why +
                    "; the certificate was removed, for without its copy it could not be revoked "
                    "once another one has its name"};
}

std::string text_of_file(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Those of a name, each once; made by the folder's authority or not is openssl's to say.
std::vector<std::string> issued_to(const fs::path& folder, const std::string& name) {
  std::vector<std::string> paths, texts;
  const auto add = [&](const fs::path& path) {
    const std::string text = text_of_file(path);
    if (text.empty() || std::find(texts.begin(), texts.end(), text) != texts.end()) return;
    texts.push_back(text);
    paths.push_back(path.string());
  };
  add(folder / (name + ".pem"));
  std::error_code none;
  for (const auto& one : fs::directory_iterator(folder_of_issued(folder, name), none))
    if (one.path().extension() == ".pem") add(one.path());
  return paths;
}

// Half an authority is no reason for a new one: the daemon would take it over within seconds, and
// nobody who holds a certificate of the other one would get in.
bool make_authority(const fs::path& folder) {
  const fs::path certificate = folder / "authority.pem", key = folder / "authority.key";
  if (fs::exists(certificate) && fs::exists(key)) return false;
  if (fs::exists(certificate) || fs::exists(key)) {
    const bool keyless = fs::exists(certificate);
    throw Failure{ExitCode::bad_input, "not_found", "NO_FILE",
                  (keyless ? key : certificate).string() + " is not there, " +
                      (keyless ? certificate : key).string() +
                      " is: nothing was changed. Put the missing one beside it for this command, "
                      "or make another authority, which no present client knows, in a folder of "
                      "its own with --folder"};
  }
  const std::string subject = ("Driftwise authority " + host_name()).substr(0, 60);
  openssl(folder,
          with_new_key({"req", "-x509", "-new", "-keyout", (folder / "authority.key").string(),
                        "-out", (folder / "authority.pem").string(), "-days",
                        days_text(0, kAuthorityDays), "-sha256", "-subj", "/CN=" + subject,
                        "-addext", "keyUsage = critical, keyCertSign, cRLSign"}));
  // Its key signs everything and stays with who made it.
  storage::give_to_owner_of_folder((folder / "authority.pem").string());
  return true;
}

// Host names and addresses of the daemon's certificate of before; none: there is none, or it cannot
// be read.
std::vector<std::string> names_of_before(const fs::path& folder) {
  const fs::path certificate = folder / "server.pem";
  if (!fs::exists(certificate)) return {};
  std::istringstream said;
  try {
    said.str(
        openssl(folder, {"x509", "-in", certificate.string(), "-noout", "-ext", "subjectAltName"}));
  } catch (const Failure&) {
    return {};  // damaged: it is made anew
  }
  std::vector<std::string> names;
  for (std::string word; said >> word;) {
    if (word.ends_with(',')) word.pop_back();
    const auto colon = word.find(':');  // "DNS:cell7", and of "IP Address:10.0.0.7" the second word
    const std::string kind = word.substr(0, colon);
    if (colon != std::string::npos && (kind == "DNS" || kind == "Address"))
      names.push_back(word.substr(colon + 1));
  }
  return names;
}

// "::1" and "0:0:0:0:0:0:0:1" are one address.
bool is_one_name(const std::string& one, const std::string& other) {
  std::array<unsigned char, sizeof(in6_addr)> first{}, second{};
  for (const int family : {AF_INET, AF_INET6})
    if (::inet_pton(family, one.c_str(), first.data()) == 1 &&
        ::inet_pton(family, other.c_str(), second.data()) == 1)
      return first == second;
  return one == other;
}

ExitCode cert_init(const Session& session, const CertificateArguments& a) {
  const fs::path folder = fs::path(session.console.working_folder) / a.folder;
  std::vector<std::string> names = {"localhost", "127.0.0.1", "::1", host_name()};
  std::vector<std::string> further;
  for (const auto& name : a.names.empty() ? names_of_before(folder) : a.names)
    if (std::ranges::none_of(names, [&](const auto& has) { return is_one_name(has, name); })) {
      names.push_back(name);
      further.push_back(name);
    }
  std::string alternative;
  for (const auto& name : names) {
    if (!is_address(name)) check_plain(name, "--name", "*");
    alternative +=
        (alternative.empty() ? "" : ", ") + std::string(is_address(name) ? "IP:" : "DNS:") + name;
  }
  make_folder(folder);
  const bool fresh = make_authority(folder);
  const std::string subject = further.empty() ? host_name() : further.front();
  sign(For::daemon, folder, "server", subject.substr(0, 60), "serverAuth", alternative,
       days_text(a.days, kServerDays));
  if (fresh || !fs::exists(folder / "revoked.pem")) {
    for (const char* of_before : {"authority.index", "authority.crlnumber"}) {
      std::error_code none;
      if (fresh) fs::remove(folder / of_before, none);
    }
    write_revocations(folder);
  }
  const auto path = [&](const char* name) { return (fs::path(a.folder) / name).string(); };
  if (session.console.json) {
    session.console.print_json({{"certificate", path("server.pem")},
                                {"key", path("server.key")},
                                {"authority", path("authority.pem")},
                                {"revoked", path("revoked.pem")},
                                {"names", names},
                                {"new_authority", fresh}});
    return ExitCode::done;
  }
  session.console.out << "[access]\nlisten = \"0.0.0.0:50052\"\ncertificate = \""
                      << path("server.pem") << "\"\nkey = \"" << path("server.key")
                      << "\"\nauthority = \"" << path("authority.pem") << "\"\nrevoked = \""
                      << path("revoked.pem") << "\"\n";
  session.console.err << (fresh ? "a new authority is in " : "signed by the authority in ")
                      << path("authority.pem") << "; its key " << path("authority.key")
                      << " signs every further certificate: keep it off this computer until then\n"
                      << "clients reach the daemon as " << alternative << "\n"
                      << "the lines above belong into the cell file; clients need "
                      << path("authority.pem") << " (--tls-ca)\n";
  return ExitCode::done;
}

ExitCode cert_client(const Session& session, const CertificateArguments& a) {
  const fs::path folder = fs::path(session.console.working_folder) / a.folder;
  check_plain(a.name, "NAME", "");
  if (a.name == "authority" || a.name == "server")
    throw Failure{ExitCode::bad_input, "invalid_argument", "BAD_NAME",
                  "NAME: '" + a.name + "' is the name of a file of 'driftwise cert init'"};
  if (!fs::exists(folder / "authority.key"))
    throw Failure{ExitCode::bad_input, "not_found", "NO_FILE",
                  (folder / "authority.key").string() +
                      " is not there: put it there for this command, name its folder with "
                      "--folder, or make an authority with 'driftwise cert init' where there is "
                      "none yet"};
  sign(For::client, folder, a.name, a.name, "clientAuth", "URI:driftwise:role/" + a.role,
       days_text(a.days, kClientDays));
  keep_issued(folder, a.name);
  const auto path = [&](const std::string& name) { return (fs::path(a.folder) / name).string(); };
  if (session.console.json)
    session.console.print_json({{"certificate", path(a.name + ".pem")},
                                {"key", path(a.name + ".key")},
                                {"authority", path("authority.pem")},
                                {"role", a.role}});
  else
    session.console.out << "driftwise --server HOST:50052 --tls-ca " << path("authority.pem")
                        << " --tls-cert " << path(a.name + ".pem") << " --tls-key "
                        << path(a.name + ".key") << " status\n";
  return ExitCode::done;
}

ExitCode cert_revoke(const Session& session, const CertificateArguments& a) {
  const fs::path folder = fs::path(session.console.working_folder) / a.folder;
  check_plain(a.name, "NAME", "");
  if (a.name == "authority" || a.name == "server")
    throw Failure{ExitCode::bad_input, "invalid_argument", "BAD_NAME",
                  "NAME: '" + a.name + "' is no client: 'driftwise cert init' makes it anew"};
  if (!fs::exists(folder / "authority.key"))
    throw Failure{
        ExitCode::bad_input, "not_found", "NO_FILE",
        (folder / "authority.key").string() +
            " is not there: the list is signed by the authority's key; revoke where it is "
            "kept, and copy revoked.pem to the daemon"};
  const auto issued = issued_to(folder, a.name);
  const Scratch settings(folder / ".revoke.cnf");
  write_list_settings(folder, settings);
  if (issued.empty())
    throw Failure{ExitCode::bad_input, "not_found", "NO_FILE",
                  (folder / (a.name + ".pem")).string() +
                      " is not there: put the certificate in its place, and revoke it then"};
  // openssl refuses what is revoked already: that is told, and the list is written all the same.
  std::size_t already = 0;
  for (const auto& one : issued) try {
      openssl(folder, {"ca", "-batch", "-config", settings.path(), "-revoke", one});
    } catch (const Failure& failure) {
      if (failure.message.find("lready revoked") == std::string::npos) throw;
      ++already;
    }
  write_revocations(folder);
  const std::string list = (fs::path(a.folder) / "revoked.pem").string();
  if (session.console.json)
    session.console.print_json({{"name", a.name},
                                {"revoked", issued.size() - already},
                                {"revoked_before", already},
                                {"list", list}});
  else
    session.console.out << a.name << ": " << issued.size() - already
                        << (issued.size() - already == 1 ? " certificate" : " certificates")
                        << " revoked now, " << already << " before; " << list
                        << " is for the daemon ([access] revoked), which reads it within seconds\n";
  return ExitCode::done;
}

}  // namespace

void add_certificate_commands(CLI::App& app, Session& session) {
  CLI::App& certificates =
      *app.add_subcommand("cert", "Certificates of an authority of your own; no daemon is asked")
           ->require_subcommand(1);
  auto a = std::make_shared<CertificateArguments>();
  const auto shared = [&](CLI::App& command) {
    command.add_option("--folder", a->folder, "of the certificates and keys")->default_str("tls");
    command.add_option("--days", a->days, "how long it is good")
        ->check(number_between(0.001, 36500));
  };
  CLI::App& beginning =
      add_command(certificates, session, "init",
                  "An authority, where there is none, and a new certificate for the daemon",
                  [&session, a] { return cert_init(session, *a); });
  beginning.add_option(
      "--name", a->names,
      "host name or address that clients use, besides this host's; without it those of "
      "the certificate of before");
  shared(beginning);
  CLI::App& client = add_command(certificates, session, "client",
                                 "A certificate for a person or a program, with a role",
                                 [&session, a] { return cert_client(session, *a); });
  client.add_option("NAME", a->name, "who it is: stands in the record")->required();
  client.add_option("--role", a->role, "viewer, controller, operator, engineer or admin")
      ->required()
      ->check(CLI::IsMember(role_names()));
  shared(client);
  CLI::App& revoking =
      add_command(certificates, session, "revoke", "Every certificate of a name counts no longer",
                  [&session, a] { return cert_revoke(session, *a); });
  revoking.add_option("NAME", a->name, "for whom it was made")->required();
  revoking.add_option("--folder", a->folder, "of the certificates and keys")->default_str("tls");
}

}  // namespace driftwise::cli
