// Trouble that may pass, told while a command goes on.
#pragma once

#include <string>

namespace repose::cli {

/// On stderr, from any thread.
void print_warning(const std::string& sentence);

}  // namespace repose::cli
