// What this board and the image on it are called.
#pragma once

#include "../core/request_server.h"

namespace tfsat {
namespace sequencer {

// Takes about a quarter of a second: the CRC covers the whole image. Calls `meanwhile` every
// millisecond or so.
Identity read_identity(protocol::ResetCause cause, void (*meanwhile)());

}  // namespace sequencer
}  // namespace tfsat
