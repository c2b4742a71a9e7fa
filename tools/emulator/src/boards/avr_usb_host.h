// A small USB host at the other end of the sequencer's cable: it enumerates the Arduino core's CDC
// serial device in simavr, opens the port and carries bytes every 125 us.
//
// simavr 1.6 models endpoints and the attach line; what it leaves out is supplied here: VBUS, start
// of frame (the core flushes its transmit buffer on it), suspend after 3 ms without traffic and
// wake-up. Not modelled: the second bank of an endpoint, bus errors, the 48 MHz PLL's lock time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "avr_io.h"

namespace tfsat {
namespace emulator {

class AvrUsbHost {
 public:
  explicit AvrUsbHost(avr_t* avr);
  AvrUsbHost(const AvrUsbHost&) = delete;
  AvrUsbHost& operator=(const AvrUsbHost&) = delete;

  void reset();  // call from avr->reset: the device is gone from the bus
  void start();  // call after every reset: begins polling
  void set_cable(bool plugged);
  // The program on the host opens (DTR and RTS on) or closes the serial port at this rate. What it
  // wrote and the board has not taken goes with a closed port.
  void set_port(bool open, uint32_t baud);
  // Resets the bus and sets the address at once: a host that leaves out the 10 ms which a device has
  // to recover (USB 2.0, section 7.1.7.5). Only where the device is enumerated.
  void reset_bus();
  // A busy host: it rests this many polls of 125 us after each stage of a control transfer.
  void set_stage_pause(uint32_t ticks) { stage_pause_ticks_ = ticks; }
  // A broken host: each so many polls it begins a control transfer and leaves it at that, and makes no
  // other; 0: a sound one.
  void set_half_transfers(uint32_t every_ticks) { half_transfer_ticks_ = every_ticks; }

  bool configured() const { return state_ == State::kConfigured; }
  size_t write(const uint8_t* data, size_t n);
  size_t read(uint8_t* data, size_t capacity);

 private:
  enum class State : uint8_t { kDetached, kDebounce, kReset, kEnumerating, kConfigured };
  enum class Stage : uint8_t { kIdle, kSetup, kDataIn, kDataOut, kStatusIn, kStatusOut };

  struct Request {
    uint8_t type, request;
    uint16_t value, index, length;
  };

  // Sized like a pseudo-terminal: a program that does not read stops the board's sending.
  static constexpr size_t kBufferBytes = 4096;
  static constexpr size_t kPacketBytes = 64;

  bool attached() const;
  void detach();
  void tick();
  void frame();
  void suspend();
  void raise_device_event(uint8_t bit);
  void enumerate();
  void begin_request(const Request& request);
  void send_setup(const Request& request);
  bool run_half_transfers();
  bool run_request();
  bool run_stage();
  void run_port_requests();
  void carry_bytes();
  int transfer(uint32_t ioctl, uint8_t endpoint, uint8_t* data, uint32_t& size);
  void give_up();

  static void on_ueintx_write(void* self, uint8_t value);
  static void on_udien_write(void* self, uint8_t value);
  static void on_ueienx_write(void* self, uint8_t value);
  static avr_cycle_count_t on_tick(avr_t*, avr_cycle_count_t when, void* self);

  avr_t* avr_;
  avr_int_vector_t *general_vector_, *endpoint_vector_;
  WriteTap ueintx_tap_, udien_tap_, ueienx_tap_;

  bool plugged_ = false, suspended_ = false;
  bool port_open_ = true, port_sent_open_ = false, line_coding_sent_ = false;
  uint32_t baud_ = 115200;
  State state_ = State::kDetached;
  uint32_t ticks_ = 0, state_ticks_ = 0, idle_ticks_ = 0;
  uint16_t frame_number_ = 0;

  Stage stage_ = Stage::kIdle;
  Request request_{};
  size_t enumeration_step_ = 0;
  bool setup_taken_ = false, data_taken_ = true;
  uint32_t request_ticks_ = 0;
  uint32_t stage_pause_ticks_ = 0, pause_left_ticks_ = 0, half_transfer_ticks_ = 0;
  uint16_t request_done_ = 0;

  std::deque<uint8_t> to_board_, from_board_;
};

}  // namespace emulator
}  // namespace tfsat
