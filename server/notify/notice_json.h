#pragma once
// Messages as JSON. Pure.

#include <string>

#include "server/core/records/notify_records.h"
#include "server/core/result.h"

namespace driftwise::notify {

// Alertmanager's webhook, version 4. Source: prometheus.io/docs/alerting/latest/configuration,
// "webhook_config". A test is one alert named notify.test.
std::string webhook_json(const std::string& receiver, const Notice& notice);

// {"cell", "version", "at", "run", "run_state", "alarms", "chain": "HASH@N", "every_s"}; chain is
// empty where the record has none yet.
std::string life_sign_json(const LifeSign& sign);
// The same read; errors: invalid_argument BAD_LIFE_SIGN.
Result<LifeSign> life_sign_from(const std::string& json);

}  // namespace driftwise::notify
