#pragma once
// Receivers of tests/peers/notify as processes, and what they kept.

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/process.h"

namespace driftwise::tests {

inline const std::string kPeers = DRIFTWISE_SOURCE_DIR "/tests/peers/notify/";

class Receiver {
 public:
  std::string port() const { return port_; }
  std::vector<nlohmann::json> kept() const {
    std::vector<nlohmann::json> out;
    std::ifstream file(file_);
    for (std::string line; std::getline(file, line);) out.push_back(nlohmann::json::parse(line));
    return out;
  }

 protected:
  explicit Receiver(std::string file) : file_(std::move(file)) {}
  void start(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "/usr/bin/python3");
    process_ = std::make_unique<Process>(arguments);
    const auto line = process_->read_line(std::chrono::seconds(60));
    if (!line || !line->starts_with("READY ")) throw std::runtime_error("no receiver");
    port_ = line->substr(6);
  }
  std::string file_, port_;
  std::unique_ptr<Process> process_;
};

// Python's own HTTP server.
class HttpReceiver : public Receiver {
 public:
  // mode: ok, 500, hang, slow.
  HttpReceiver(const std::string& folder, const std::string& name, const std::string& mode)
      : Receiver(folder + "/" + name + ".kept"), mode_(folder + "/" + name + ".mode") {
    become(mode);
    start({kPeers + "http_receiver.py", file_, mode_});
  }
  void become(const std::string& mode) const { write_file(mode_, mode); }
  std::string url() const { return "http://127.0.0.1:" + port_ + "/hook"; }
  // The bodies that were answered with success.
  std::vector<nlohmann::json> taken() const {
    std::vector<nlohmann::json> out;
    for (const auto& line : kept())
      if (line.at("mode") == "ok" || line.at("mode") == "slow")
        out.push_back(nlohmann::json::parse(line.at("body").get<std::string>()));
    return out;
  }

 private:
  std::string mode_;
};

// aiosmtpd; with a certificate and key it wants STARTTLS and AUTH.
class MailReceiver : public Receiver {
 public:
  explicit MailReceiver(const std::string& folder, std::vector<std::string> tls = {})
      : Receiver(folder + "/mails.kept") {
    tls.insert(tls.begin(), {kPeers + "mail_receiver.py", file_});
    start(tls);
  }
  std::string url() const { return "smtp://127.0.0.1:" + port_; }
};

}  // namespace driftwise::tests
