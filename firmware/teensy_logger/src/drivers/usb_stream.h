// The USB serial port, never waited for.
#pragma once

#include <Arduino.h>

#include "../protocol/link.h"

namespace tfsat {
namespace logger {

class UsbStream final : public protocol::ByteStream {
 public:
  // USB is configured and a program on the host holds the port open (DTR).
  bool connected() override { return static_cast<bool>(Serial); }

  int read() override { return Serial.read(); }

  // Serial.write() waits for a host that does not read, unless it is given no more than fits.
  size_t write(const uint8_t* data, size_t size) override {
    const int room = Serial.availableForWrite();
    if (room <= 0) return 0;
    return Serial.write(data, size < static_cast<size_t>(room) ? size : static_cast<size_t>(room));
  }
};

}  // namespace logger
}  // namespace tfsat
