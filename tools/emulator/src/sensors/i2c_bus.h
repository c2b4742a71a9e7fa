// An I2C bus with register-addressed slaves, as a master's driver sees it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tfsat {
namespace emulator {

class I2cDevice {
 public:
  virtual ~I2cDevice() = default;
  // Register address, then `n` bytes; the address moves on by one per byte. False: no acknowledge.
  virtual bool write(uint8_t reg, const uint8_t* data, size_t n) = 0;
  virtual bool read(uint8_t reg, uint8_t* data, size_t n) = 0;
};

class I2cBus {
 public:
  static constexpr int kMaxDevices = 8;
  static constexpr uint32_t kFastHz = 400000;

  // The device stays the caller's. False if the address is taken or the bus is full.
  bool attach(uint8_t address, I2cDevice& device) {
    if (find(address) != nullptr || n_devices_ == kMaxDevices) return false;
    slots_[n_devices_++] = {address, &device, false, false};
    return true;
  }

  // Another device answers at an address that is taken: its plug was put there.
  void plug(uint8_t address, I2cDevice& device) {
    for (Slot& slot : slots_)
      if (slot.device != nullptr && slot.address == address) slot.device = &device;
  }

  // False: nobody acknowledged, or a line is held low and no transfer is possible.
  bool write(uint8_t address, uint8_t reg, const uint8_t* data, size_t n) {
    I2cDevice* device = stuck_ || glitch_over(address) ? nullptr : find(address);
    return device != nullptr && device->write(reg, data, n);
  }
  bool read(uint8_t address, uint8_t reg, uint8_t* data, size_t n) {
    I2cDevice* device = stuck_ || glitch_over(address) ? nullptr : find(address);
    return device != nullptr && device->read(reg, data, n);
  }

  // Fault: a slave holds SDA low. It lets go after the nine clocks that a driver sends to free it,
  // unless the line is shorted.
  void set_stuck(bool stuck, bool shorted = false) {
    stuck_ = stuck || shorted;
    shorted_ = shorted;
  }
  bool stuck() const { return stuck_; }
  void clock_free() { stuck_ = shorted_; }

  // Fault: the slave at this address stops in the middle of each of its transfers and holds the bus
  // until it is clocked free.
  void set_hanging(uint8_t address, bool hanging) {
    for (Slot& slot : slots_) slot.hanging = slot.address == address ? hanging : slot.hanging;
  }
  bool hangs(uint8_t address) const {
    for (const Slot& slot : slots_)
      if (slot.address == address) return slot.hanging;
    return false;
  }

  // Fault: the next transfer with this address meets a disturbance, and nobody acknowledges.
  void glitch(uint8_t address) {
    for (Slot& slot : slots_) slot.glitch |= slot.address == address;
  }

  // How long its pull-ups take to raise the clock line to the master's threshold. At 400 kHz a master
  // that counts a bit's high time from there makes each bit so much longer.
  void set_rise_ns(uint32_t rise_ns) { rise_ns_ = rise_ns; }

  // How long a transfer keeps the bus (I2C: 9 clocks a byte, about 1 for each start and stop).
  uint64_t nack_duration_us(uint32_t clock_hz) const { return bits_us(9 + 2, clock_hz); }
  uint64_t write_duration_us(size_t n, uint32_t clock_hz) const {
    return bits_us(9 * (2 + n) + 2, clock_hz);
  }
  uint64_t read_duration_us(size_t n, uint32_t clock_hz) const {
    return bits_us(9 * (3 + n) + 3, clock_hz);
  }

 private:
  struct Slot {
    uint8_t address;
    I2cDevice* device;
    bool hanging;
    bool glitch;
  };
  uint64_t bits_us(uint64_t bits, uint32_t clock_hz) const {
    const uint64_t rise_ns = clock_hz == kFastHz ? rise_ns_ : 0;
    return (bits * 1000000u + clock_hz - 1) / clock_hz + (bits * rise_ns + 999) / 1000;
  }
  bool glitch_over(uint8_t address) {
    for (Slot& slot : slots_) {
      if (slot.address != address || !slot.glitch) continue;
      slot.glitch = false;
      return true;
    }
    return false;
  }
  I2cDevice* find(uint8_t address) const {
    for (int i = 0; i < n_devices_; ++i)
      if (slots_[i].address == address) return slots_[i].device;
    return nullptr;
  }

  Slot slots_[kMaxDevices] = {};
  int n_devices_ = 0;
  uint32_t rise_ns_ = 0;
  bool stuck_ = false, shorted_ = false;
};

}  // namespace emulator
}  // namespace tfsat
