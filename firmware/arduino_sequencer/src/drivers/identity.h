// What this board and the image on it are called.
#pragma once

#include "../core/request_server.h"
#include "../protocol/crc32.h"

namespace tfsat {
namespace sequencer {

// But for the image's CRC.
Identity read_identity(protocol::ResetCause cause);

// Covers the whole image, which takes a quarter of a second: piece by piece, so that the main loop goes on.
class ImageCrc {
 public:
  // Reads a piece, in 1.4 ms; true, and `crc` is the image's, once there is no more.
  bool read_on(uint32_t& crc);

 private:
  protocol::Crc32 crc_;
  uint16_t address_ = 0;
};

}  // namespace sequencer
}  // namespace tfsat
