// Who this board is and what was flashed on it.
#pragma once

#include "../core/logger.h"

namespace tfsat {
namespace logger {

// Reads the chip's unique id and the whole flash image (about 5 ms).
Identity read_identity();

}  // namespace logger
}  // namespace tfsat
