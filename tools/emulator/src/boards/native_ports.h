// The PC's side of the sequencer core's ports: what AVR peripherals do, in virtual time.
#pragma once

#include <array>
#include <cstdint>
#include <deque>

#include "../../../../firmware/arduino_sequencer/src/core/ports.h"
#include "../../../../firmware/arduino_sequencer/src/core/pulse_train.h"
#include "../../../../firmware/arduino_sequencer/src/protocol/link.h"
#include "sequencer_board.h"

namespace tfsat {
namespace emulator {

constexpr uint64_t kNanosecondsPerTick = 500;

// Three servo signals and the stroke line, from the same PulseTrain that the AVR's interrupts ask.
class NativeServos : public sequencer::ServoOutput {
 public:
  // `holds`: of each servo's pin, as they are when the board starts.
  explicit NativeServos(sequencer::BegunChanges& begun,
                        const std::array<PinHold, protocol::kJointCount>& holds = {});

  void hold(uint8_t joint, uint16_t width_ticks, uint32_t frame_ticks) override;
  void schedule(uint8_t joint, sequencer::tick_t at, uint16_t width_ticks) override;
  bool cancel() override;
  void stop() override;
  uint16_t changes_begun() override { return changes_.begun(); }
  sequencer::tick_t change_began_at(uint8_t index) override { return changes_.began_at(index); }

  void hold_pin(int joint, PinHold hold, uint64_t origin_ns, std::deque<PinEdge>& edges);

  // Runs the signals up to `t_ns` after the board's start and appends their edges, in order of time,
  // to `edges` with `origin_ns` added.
  void advance_to(uint64_t t_ns, uint64_t origin_ns, std::deque<PinEdge>& edges);
  // The supply or the processor is gone: pins that it drives high fall.
  void release_pins(uint64_t origin_ns, std::deque<PinEdge>& edges) const;

 private:
  struct Channel {
    Channel(sequencer::ChangeTable& changes, uint8_t joint) : train(changes, joint) {}

    sequencer::PulseTrain train;
    PinHold hold = PinHold::kFree;
    bool high = false;     // as driven
    bool level = false;    // of the pin
    bool whole = false;    // the pulse so far, as the AVR's interrupts see it
    bool pending = false;  // a pulse is planned or under way
    sequencer::Pulse pulse{};
    uint64_t rise_ns = 0;
    uint64_t fall_ns = 0;
  };

  sequencer::tick_t ticks() const { return static_cast<sequencer::tick_t>(now_ns_ / kNanosecondsPerTick); }
  void plan(Channel& channel);
  void forget_changes();
  bool update_level(uint8_t joint, uint64_t t_ns, std::deque<PinEdge>& edges);
  void begin_stroke_mark(uint64_t origin_ns, std::deque<PinEdge>& edges);
  uint64_t next_edge_ns(const Channel& channel) const;

  sequencer::ChangeTable changes_;
  std::array<Channel, protocol::kJointCount> channels_{{{changes_, 0}, {changes_, 1}, {changes_, 2}}};
  uint64_t now_ns_ = 0;
  uint64_t stroke_line_falls_ns_ = 0;
  bool stroke_line_high_ = false;
};

class NativeSwitches : public sequencer::ReleaseSwitches {
 public:
  bool take_edge(sequencer::SwitchEdge& edge) override;
  uint8_t levels() override { return open_; }

  void set(int index, bool open, sequencer::tick_t at);

 private:
  std::deque<sequencer::SwitchEdge> edges_;
  uint8_t open_ = 0;
};

// 1 KiB of EEPROM; a write takes 3.4 ms (ATmega32U4 datasheet, tab. 5-1).
class NativeEeprom : public sequencer::NonVolatile {
 public:
  static constexpr size_t kBytes = 1024;

  NativeEeprom() { image_.fill(0xFF); }

  uint8_t read(uint16_t address) override { return image_[address % kBytes]; }
  bool busy() override { return now_us_ < busy_until_us_; }
  void write(uint16_t address, uint8_t value) override;

  void set_now(uint64_t t_us) { now_us_ = t_us; }
  // A reset: the chip completes the byte under way while the program starts.
  void complete_write() { busy_until_us_ = now_us_; }
  // Power goes: a write under way is lost.
  void power_cut();
  std::array<uint8_t, kBytes>& image() { return image_; }
  // Writes begun, and cuts that undid one.
  uint32_t writes() const { return writes_; }

 private:
  static constexpr uint64_t kWriteUs = 3400;

  std::array<uint8_t, kBytes> image_;
  uint64_t now_us_ = 0;
  uint64_t busy_until_us_ = 0;
  uint32_t writes_ = 0;
  uint16_t address_ = 0;
  uint8_t old_value_ = 0;
};

// A PC's stack has no low-water mark worth telling.
class NativeHealth : public sequencer::Health {
 public:
  uint16_t ram_never_used_bytes() override { return UINT16_MAX; }
};

// The USB cable and the host's end of it: bytes both ways, lost when the cable is pulled. A closed
// port (DTR) loses what the host has not read.
class NativeStream : public protocol::ByteStream {
 public:
  bool connected() override { return plugged_ && port_open_; }
  int read() override;
  size_t write(const uint8_t* data, size_t size) override;

  void set_plugged(bool plugged);
  void set_port(bool open);
  size_t host_write(const uint8_t* data, size_t size);
  size_t host_read(uint8_t* data, size_t capacity);
  void clear();

 private:
  // As much as USB endpoints and the host's driver hold before a writer has to wait.
  static constexpr size_t kCapacity = 4096;

  std::deque<uint8_t> to_board_;
  std::deque<uint8_t> to_host_;
  bool plugged_ = true;
  bool port_open_ = true;
};

}  // namespace emulator
}  // namespace tfsat
