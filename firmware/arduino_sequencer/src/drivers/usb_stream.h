// The USB serial port as a byte stream that never waits.
//
// Two paths of the Arduino core (USBCore.cpp 1.8.x) wait for the host, and are kept away from:
//   - USB_Send() waits up to 250 ms for room, and fills a buffer only to wait for a second one to
//     end it with. write() hands on less than the room there is, with interrupts off in between.
//   - The control endpoint's interrupt waits for the host's next packet with all interrupts off: a
//     slow host would stretch a servo pulse, a pulled cable would stop the board. serve() runs that
//     handler from the main loop instead, where interrupts go on, and abandons it if the host is
//     silent, or as soon as a release switch moves. It also serves the bus (reset, start of frame, suspend), whose own interrupt would
//     enable the other after a reset.
#pragma once

#include "../protocol/link.h"

namespace tfsat {
namespace sequencer {

class UsbStream : public protocol::ByteStream {
 public:
  // Serves the bus, and a host's control request if there is one; takes at most 10 ms. Call first in
  // the program, then from the main loop each millisecond or so. The request stays where it is while
  // `hurried` says that the main loop is waited for.
  void serve(bool (*hurried)());

  bool connected() override;
  int read() override;
  size_t write(const uint8_t* data, size_t size) override;
};

}  // namespace sequencer
}  // namespace tfsat
