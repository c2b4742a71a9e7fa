// What the core asks of the hardware. The Teensy drivers and the emulator each implement these.
//
// Two contexts run the core: the sampling timer's interrupt and the main loop. The interrupt may
// come at any point of the main loop and runs to its end before the main loop goes on. Each port
// says who calls it; a port is called by one of them only, unless it says otherwise.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "../protocol/messages.h"

namespace tfsat {
namespace logger {

enum class I2cResult : uint8_t {
  kBusy,     // still under way
  kDone,     // all bytes were transferred
  kNack,     // nobody answers at this address
  kTimeout,  // not over after its deadline; the driver has given the transfer up
  kStuck,    // a line is held low: nothing was sent
};

// One I2C master, called from the interrupt. Transfers are begun and polled, so that two buses run
// side by side; the driver ends each transfer within its deadline (timing.h) by itself.
class I2cBus {
 public:
  // Before the first transfer, and between two.
  virtual void set_clock(uint16_t khz) = 0;
  // Begin one transfer. `data` must stay until poll() returns something other than kBusy.
  virtual void start_read(uint8_t address, uint8_t reg, uint8_t* data, uint8_t size) = 0;
  virtual void start_write(uint8_t address, uint8_t reg, uint8_t value) = 0;
  // The outcome of the transfer that was begun last.
  virtual I2cResult poll() = 0;
  // Clocks a bus free that a slave holds low, and starts the master afresh. At most
  // kI2cRecoveryUs (timing.h).
  virtual void recover() = 0;

 protected:
  ~I2cBus() = default;
};

// The angle sensors' converter, 12 bit, called from the interrupt.
class Adc {
 public:
  // Converts all channels. Returns a bit for each one that was converted.
  virtual uint8_t read(uint16_t counts[protocol::kAngleSensorCount]) = 0;

 protected:
  ~Adc() = default;
};

// A change of one of the digital inputs, stamped when it came.
struct Edge {
  uint64_t t_us;
  enum class Source : uint8_t { kSwitch, kStroke } source;
  uint8_t index;  // switch 0 or 1; for strokes 0
  bool open;      // switches: it opened; strokes: true
  uint16_t lost;  // edges before this one that came too fast to be kept
};

// Release switches and the sequencer's stroke line.
class Inputs {
 public:
  // The oldest edge not yet taken; false when there is none. Called from the interrupt.
  virtual bool take_edge(Edge& edge) = 0;
  // Bit 0, 1: switch 1, 2 is open now. Called from both.
  virtual uint8_t switches_open() = 0;

 protected:
  ~Inputs() = default;
};

// The card, seen as one file of a fixed number of 512-byte blocks. Called from the main loop; an
// error is a value of ErrorCode, kNone when all is well. After an error the next call is recover()
// or open().
class BlockSink {
 public:
  // Creates the next file and allocates it in one piece. Its blocks are then filled with zeros, from
  // the first on, by prepare(). May take a second.
  virtual protocol::ErrorCode open(uint32_t n_blocks) = 0;
  // The card takes nothing now. A card that is gone may look busy for ever. Comes first in each pass
  // of the main loop, with its time.
  virtual bool busy(uint64_t t_us) = 0;
  // Fills another piece of the file while not busy. It takes the processor: a millisecond of what
  // sampling leaves of it.
  virtual protocol::ErrorCode prepare() = 0;
  // So many blocks of the file may be written; all of them in the end.
  virtual uint32_t prepared_blocks() = 0;
  // Starts the card anew, as after a loss of contact, and goes on with the same file. What was
  // written since the last sync() may be lost. kNone: it may be written to again. May take as long
  // as open().
  virtual protocol::ErrorCode recover(uint64_t t_us) = 0;
  // Hands over one block that is prepared, while not busy. The same index may be written again.
  virtual protocol::ErrorCode write(uint32_t index, const uint8_t* block) = 0;
  // Tells the card to put its own buffers on the medium.
  virtual protocol::ErrorCode sync() = 0;
  // Shortens the file to `n_blocks` and closes it: the only change of metadata since open().
  virtual protocol::ErrorCode close(uint32_t n_blocks) = 0;
  // Looks at the card while no file is open: kNone when a file of `n_blocks` would find room. kBusy
  // when it has just met the card and counts its free room, a step at each call; a step may take
  // 20 ms, the first one as long as a card takes to start.
  virtual protocol::ErrorCode inspect(uint32_t n_blocks) = 0;
  // Room on the card when it was counted last.
  virtual uint32_t free_mib() = 0;

 protected:
  ~BlockSink() = default;
};

// The recordings on the card. Called from the main loop while nothing is recorded.
class LogArchive {
 public:
  // The recording whose number is the first from `from` on: its number and size; false if none.
  virtual bool find(uint16_t from, uint16_t& number, uint32_t& n_blocks) = 0;
  // One block of it; kNoSuchLog beyond its end.
  virtual protocol::ErrorCode read(uint16_t number, uint32_t index, uint8_t* block) = 0;
  virtual protocol::ErrorCode erase(uint16_t number) = 0;

 protected:
  ~LogArchive() = default;
};

// The timer that calls Logger::sample(). Called from the main loop.
class SampleTimer {
 public:
  virtual void start(uint16_t rate_hz) = 0;
  // No call comes after it returns.
  virtual void stop() = 0;

 protected:
  ~SampleTimer() = default;
};

// A few bytes that outlast the power. Called from the main loop while nothing is recorded: writing
// may hold up interrupts.
class NonVolatile {
 public:
  virtual void load(uint8_t* bytes, uint8_t size) = 0;
  virtual void save(const uint8_t* bytes, uint8_t size) = 0;

 protected:
  ~NonVolatile() = default;
};

// Where session ids come from. Called from the main loop.
class Entropy {
 public:
  virtual uint32_t next() = 0;

 protected:
  ~Entropy() = default;
};

}  // namespace logger
}  // namespace tfsat
