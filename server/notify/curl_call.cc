#include "server/notify/curl_call.h"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"

namespace driftwise::notify {
namespace {

constexpr std::size_t kMostKept = 4096;

struct EasyEnd {
  void operator()(CURL* handle) const { curl_easy_cleanup(handle); }
};
struct ListEnd {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
using Easy = std::unique_ptr<CURL, EasyEnd>;
using List = std::unique_ptr<curl_slist, ListEnd>;

void add(List& list, const std::string& line) {
  if (curl_slist* longer = curl_slist_append(list.get(), line.c_str())) {
    static_cast<void>(list.release());  // it is the head of the longer one
    list.reset(longer);
  }
}

std::size_t keep_bytes(char* bytes, std::size_t size, std::size_t count, void* into) {
  auto& text = *static_cast<std::string*>(into);
  text.append(bytes, std::min(size * count, kMostKept - std::min(kMostKept, text.size())));
  return size * count;
}

// Answers of a mail server.
struct MailTalk {
  struct Refused {
    std::string address, why;
  };
  std::string command;           // sent last
  std::string last, refusal;     // its last line, and its last refusal (4xx, 5xx)
  std::vector<Refused> refused;  // recipients
};

std::string between(const std::string& text, char begin, char end) {
  const auto from = text.find(begin);
  if (from == std::string::npos) return {};
  return text.substr(from + 1, text.find(end, from) - from - 1);
}

int note_command(CURL*, curl_infotype kind, char* bytes, std::size_t size, void* into) {
  if (kind == CURLINFO_HEADER_OUT)
    static_cast<MailTalk*>(into)->command.assign(bytes, std::min(size, kMostKept));
  return 0;
}

std::size_t note_answer(char* bytes, std::size_t size, std::size_t count, void* into) {
  auto& talk = *static_cast<MailTalk*>(into);
  std::string line(bytes, std::min(size * count, kMostKept));
  line.erase(line.find_last_not_of("\r\n") + 1);
  if (line.empty()) return size * count;
  if (line.front() != '4' && line.front() != '5') {
    talk.last = clean_line(line);
    return size * count;
  }
  talk.refusal = clean_line(line);
  if (talk.command.starts_with("RCPT TO:")) {
    const auto address = between(talk.command, '<', '>');
    // A refusal may have several lines.
    if (talk.refused.empty() || talk.refused.back().address != address)
      talk.refused.push_back({address, {}});
    talk.refused.back().why = talk.refusal;
  }
  return size * count;
}

struct Upload {
  const std::string& text;
  std::size_t sent = 0;
};

std::size_t give_bytes(char* bytes, std::size_t size, std::size_t count, void* from) {
  auto& upload = *static_cast<Upload*>(from);
  const std::size_t taken = std::min(size * count, upload.text.size() - upload.sent);
  std::copy_n(upload.text.data() + upload.sent, taken, bytes);
  upload.sent += taken;
  return taken;
}

int look(void* stop, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
  return static_cast<const std::atomic<bool>*>(stop)->load() ? 1 : 0;
}

template <class Value>
void set(const Easy& easy, CURLoption option, Value value) {
  curl_easy_setopt(easy.get(), option, value);
}

Easy begin(const std::string& url, const std::string& ca_file, std::chrono::milliseconds limit,
           const std::atomic<bool>& stop, char* error) {
  static std::once_flag once;
  std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
  Easy easy(curl_easy_init());
  if (!easy) return easy;
  set(easy, CURLOPT_URL, url.c_str());
  set(easy, CURLOPT_PROTOCOLS_STR, "http,https,smtp,smtps");
  set(easy, CURLOPT_NOSIGNAL, 1L);
  set(easy, CURLOPT_PROXY, "");
  set(easy, CURLOPT_TIMEOUT_MS, static_cast<long>(limit.count()));
  set(easy, CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(limit.count() / 2));
  set(easy, CURLOPT_NOPROGRESS, 0L);
  set(easy, CURLOPT_XFERINFOFUNCTION, &look);
  set(easy, CURLOPT_XFERINFODATA, const_cast<std::atomic<bool>*>(&stop));
  set(easy, CURLOPT_ERRORBUFFER, error);
  set(easy, CURLOPT_SSLVERSION, static_cast<long>(CURL_SSLVERSION_TLSv1_2));
  if (!ca_file.empty()) set(easy, CURLOPT_CAINFO, ca_file.c_str());
  return easy;
}

// libcurl looks at the stop about once a second by itself, so the transfer is driven step by step.
CURLcode perform(const Easy& easy, const std::atomic<bool>& stop) {
  CURLM* multi = curl_multi_init();
  if (multi == nullptr) return CURLE_OUT_OF_MEMORY;
  curl_multi_add_handle(multi, easy.get());
  CURLcode code = CURLE_ABORTED_BY_CALLBACK;
  for (int running = 1; !stop.load();) {
    if (curl_multi_perform(multi, &running) != CURLM_OK) {
      code = CURLE_FAILED_INIT;
      break;
    }
    if (running == 0) {
      int left = 0;
      const CURLMsg* message = curl_multi_info_read(multi, &left);
      code = message != nullptr && message->msg == CURLMSG_DONE ? message->data.result
                                                                : CURLE_FAILED_INIT;
      break;
    }
    curl_multi_poll(multi, nullptr, 0, 100, nullptr);
  }
  curl_multi_remove_handle(multi, easy.get());
  curl_multi_cleanup(multi);
  return code;
}

// Scheme, host and port: the path of a webhook is often its secret.
std::string shown_address(const std::string& url) {
  const auto host = url.find("://");
  return host == std::string::npos ? url : url.substr(0, url.find('/', host + 3));
}

tl::unexpected<Error> not_delivered(const std::string& url, const std::string& why) {
  return fail(ErrorCode::unavailable, reasons::kNotDelivered,
              clean_line(shown_address(url) + ": " + why));
}

tl::unexpected<Error> failed(CURLcode code, const std::string& url, const char* detail,
                             const std::string& last, const std::atomic<bool>& stop) {
  if (stop.load())
    return fail(ErrorCode::cancelled, reasons::kShuttingDown,
                shown_address(url) + ": the program ends");
  std::string why = *detail != '\0' ? detail : curl_easy_strerror(code);
  if (!last.empty()) why += "; it said last: " + last;
  return not_delivered(url, why);
}

}  // namespace

Result<std::string> post(const HttpPost& call, std::chrono::milliseconds limit,
                         const std::atomic<bool>& stop) {
  std::array<char, CURL_ERROR_SIZE> error{};
  const Easy easy = begin(call.url, call.ca_file, limit, stop, error.data());
  if (!easy) return not_delivered(call.url, "libcurl cannot begin");
  List headers;
  add(headers, "Content-Type: application/json");
  add(headers, "User-Agent: driftwise");
  add(headers, "Expect:");
  if (!call.bearer.empty()) add(headers, "Authorization: Bearer " + call.bearer);
  std::string answer;
  set(easy, CURLOPT_HTTPHEADER, headers.get());
  set(easy, CURLOPT_POSTFIELDS, call.body.c_str());
  set(easy, CURLOPT_POSTFIELDSIZE, static_cast<long>(call.body.size()));
  set(easy, CURLOPT_WRITEFUNCTION, &keep_bytes);
  set(easy, CURLOPT_WRITEDATA, &answer);
  const CURLcode code = perform(easy, stop);
  if (code != CURLE_OK) return failed(code, call.url, error.data(), "", stop);
  long status = 0;
  curl_easy_getinfo(easy.get(), CURLINFO_RESPONSE_CODE, &status);
  std::string said = "HTTP " + std::to_string(status);
  const std::string first =
      clean_line(answer.substr(0, std::min<std::size_t>(answer.find('\n'), 200)));
  if (!first.empty()) said += ": " + first;
  if (status < 200 || status > 299) return not_delivered(call.url, said);
  return said;
}

Result<Delivery> send_mail(const MailCall& call, std::chrono::milliseconds limit,
                           const std::atomic<bool>& stop) {
  std::array<char, CURL_ERROR_SIZE> error{};
  const Easy easy = begin(call.url, call.ca_file, limit, stop, error.data());
  if (!easy) return not_delivered(call.url, "libcurl cannot begin");
  List to;
  for (const auto& one : call.to) add(to, "<" + one + ">");
  const std::string from = "<" + call.from + ">";
  MailTalk talk;
  Upload upload{call.message};
  set(easy, CURLOPT_USE_SSL, static_cast<long>(call.tls ? CURLUSESSL_ALL : CURLUSESSL_NONE));
  if (!call.user.empty()) {
    set(easy, CURLOPT_USERNAME, call.user.c_str());
    set(easy, CURLOPT_PASSWORD, call.password.c_str());
  }
  set(easy, CURLOPT_MAIL_FROM, from.c_str());
  set(easy, CURLOPT_MAIL_RCPT, to.get());
  // A recipient who is refused keeps the mail from nobody else. The name of before 8.2 is known to
  // every version.
  set(easy, CURLOPT_MAIL_RCPT_ALLLOWFAILS, 1L);
  set(easy, CURLOPT_UPLOAD, 1L);
  set(easy, CURLOPT_READFUNCTION, &give_bytes);
  set(easy, CURLOPT_READDATA, &upload);
  set(easy, CURLOPT_HEADERFUNCTION, &note_answer);
  set(easy, CURLOPT_HEADERDATA, &talk);
  set(easy, CURLOPT_VERBOSE, 1L);
  set(easy, CURLOPT_DEBUGFUNCTION, &note_command);
  set(easy, CURLOPT_DEBUGDATA, &talk);
  const CURLcode code = perform(easy, stop);
  if (code != CURLE_OK) {
    auto none =
        failed(code, call.url, error.data(), talk.refusal.empty() ? talk.last : talk.refusal, stop);
    // Nobody is left whom a later try would reach.
    const bool for_good =
        talk.refused.size() == call.to.size() &&
        std::ranges::all_of(talk.refused, [](const auto& one) { return one.why.starts_with('5'); });
    if (for_good && !stop.load()) none.value().code = ErrorCode::failed_precondition;
    return none;
  }
  Delivery delivery(talk.last.empty() ? "accepted" : talk.last);
  for (const auto& one : talk.refused) {
    delivery.said += "; NOT DELIVERED to " + one.address + ": " + one.why;
    delivery.refused.push_back({one.address, one.why, one.why.starts_with('4')});
  }
  return delivery;
}

}  // namespace driftwise::notify
