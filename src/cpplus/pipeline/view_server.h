#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace cpplus {

/// Serves the files of a folder, and photos that are made when they are asked for, to this machine alone (127.0.0.1),
/// until the user asks the program to stop; then it throws Interrupted. Requests that name another host are refused, so
/// that no web page reaches it by a name of its own. `make_photo` gives the JPEG of "photos/NUMBER.jpg", or nothing
/// where there is none; it is called from several threads. Throws Error when the port is taken.
void serve_view(const std::string& folder, int port, const std::function<std::vector<uint8_t>(size_t)>& make_photo,
                const std::function<void(const std::string& address)>& on_ready);

}  // namespace cpplus
