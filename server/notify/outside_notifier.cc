#include "server/notify/outside_notifier.h"

#include <algorithm>

#include "server/core/try.h"
#include "server/notify/command_run.h"
#include "server/notify/curl_call.h"
#include "server/notify/mail_text.h"
#include "server/notify/notice_json.h"
#include "server/notify/notice_text.h"
#include "server/notify/secret_file.h"

namespace driftwise::notify {
namespace {

constexpr std::chrono::seconds kHttpLimit{15}, kMailLimit{30}, kCommandLimit{30};

Result<std::string> secret_of(const std::string& path) {
  if (path.empty()) return std::string();
  return read_secret(path);
}

bool on_loopback(std::string_view url) {
  const auto begin = url.find("://");
  const auto host = begin == std::string_view::npos ? url : url.substr(begin + 3);
  return host.starts_with("127.") || host.starts_with("localhost:") || host.starts_with("[::1]");
}

// The same message told again has the same name, so that a receiver can tell a repeated delivery.
std::string message_id(const ReceiverDescription& receiver, const Notice& notice) {
  std::string name = notice.news.empty() ? "test" : "";
  for (const auto& news : notice.news) {
    if (name.size() > 100) break;
    name += (name.empty() ? "" : ".") + std::to_string(news.alarm.id.value) +
            (news.kind == NewsKind::resolved ? "r"
             : news.kind == NewsKind::repeat ? "a"
                                             : "f");
  }
  const std::string since =
      std::to_string((notice.news.empty() ? notice.at : notice.news.front().since).ns / 1000);
  const bool repeats = std::ranges::any_of(
      notice.news, [](const AlarmNews& news) { return news.kind == NewsKind::repeat; });
  const auto at = receiver.from.rfind('@');
  return name + "." + since +
         (repeats ? "." + std::to_string(notice.at.ns / 1'000'000'000 / 60) : "") +
         (at == std::string::npos ? "@driftwise" : receiver.from.substr(at));
}

Result<Delivery> tell_by_mail(const ReceiverDescription& receiver, const Notice& notice,
                              const std::atomic<bool>& stop) {
  DRIFTWISE_TRY(const auto password, secret_of(receiver.password_file));
  const Mail mail{receiver.from,
                  receiver.to,
                  title_of(notice),
                  text_of(notice),
                  message_id(receiver, notice),
                  notice.at.ns / 1'000'000'000};
  // A mail server on this computer is often plain; one whose authority is named speaks TLS.
  const bool tls = !on_loopback(receiver.smtp) || !receiver.ca_file.empty();
  return send_mail({receiver.smtp, receiver.from, receiver.user, password, receiver.ca_file,
                    rfc5322(mail), receiver.to, tls},
                   kMailLimit, stop);
}

// "{title}" and "{text}" in an argument, each as one piece of it.
std::vector<std::string> filled_in(std::vector<std::string> command, const Notice& notice) {
  const auto replace = [](std::string& text, std::string_view what, const std::string& with) {
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
      text.replace(at, what.size(), with);
  };
  for (auto& argument : command) {
    replace(argument, "{title}", title_of(notice));
    replace(argument, "{text}", text_of(notice));
  }
  return command;
}

}  // namespace

Result<Delivery> OutsideNotifier::tell(const ReceiverDescription& receiver, const Notice& notice) {
  if (!receiver.command.empty())
    return run_command(filled_in(receiver.command, notice), webhook_json(receiver.name, notice),
                       kCommandLimit, stop_);
  if (!receiver.smtp.empty()) return tell_by_mail(receiver, notice, stop_);
  DRIFTWISE_TRY(const auto token, secret_of(receiver.token_file));
  return post({receiver.webhook, webhook_json(receiver.name, notice), token, receiver.ca_file},
              kHttpLimit, stop_);
}

Result<std::string> OutsideNotifier::report(const WatchdogRules& watchdog, const LifeSign& sign) {
  DRIFTWISE_TRY(const auto token, secret_of(watchdog.token_file));
  return post({watchdog.url, life_sign_json(sign), token, watchdog.ca_file}, kHttpLimit, stop_);
}

}  // namespace driftwise::notify
