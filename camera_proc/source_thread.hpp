// A blocking device read in a thread of its own.
#pragma once

#include "camera_proc/source.hpp"

namespace stevedore {

/// An opener whose sources open and read what `open` gives in a thread, and hand over the newest frame (an
/// older one not fetched in time is dropped). grab() waits 50 ms at most. Closing waits 0.5 s for a driver
/// that blocks and then leaves it behind: the thread ends when the driver returns, and until then the device
/// is not opened again.
Opener threaded(Opener open);

}  // namespace stevedore
