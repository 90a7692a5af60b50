#pragma once

// The flags of capture_server, which are the keys of its settings file as well: what each means, takes and is by default.

#include <CLI/CLI.hpp>

#include "capture_server/settings.h"

namespace copresence::server {

/// Adds every flag, each setting its member of `settings`, which must live while `app` parses. Those that are no keys of the file are
/// not "configurable".
void add_flags(CLI::App& app, ServerSettings& settings);

}  // namespace copresence::server
