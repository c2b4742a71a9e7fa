#include "avr_usb_host.h"

#include <simavr/avr_usb.h>

#include <algorithm>

namespace tfsat {
namespace emulator {

namespace {

constexpr uint64_t kTickCycles = 125 * kCyclesPerUs;
constexpr uint32_t kTicksPerMs = 8;
constexpr uint32_t kDebounceTicks = 10 * kTicksPerMs;
constexpr uint32_t kResetTicks = 10 * kTicksPerMs;
constexpr uint32_t kSuspendTicks = 3 * kTicksPerMs;
constexpr uint32_t kRequestTimeoutTicks = 500 * kTicksPerMs;

constexpr uint8_t kOutEndpoint = 2, kInEndpoint = 3;
constexpr uint8_t kGeneralVector = 10, kEndpointVector = 11;

// UDINT and UDIEN bits (datasheet section 22.18.1).
constexpr uint8_t kSuspend = 0, kStartOfFrame = 2, kWakeUp = 4;
constexpr uint8_t kSetupReceived = 0x08, kOutReceived = 0x04;  // UEINTX: RXSTPI, RXOUTI

constexpr uint8_t kDeviceToHost = 0x80;
constexpr uint8_t kStandardIn = 0x80, kStandardOut = 0x00, kClassInterfaceOut = 0x21;
constexpr uint8_t kSetAddress = 5, kGetDescriptor = 6, kSetConfiguration = 9;
constexpr size_t kSetAddressStep = 1;  // of enumerate()
constexpr uint8_t kSetLineCoding = 0x20, kSetControlLineState = 0x22;
constexpr uint16_t kDeviceDescriptor = 0x0100, kConfigurationDescriptor = 0x0200;
constexpr uint16_t kProductString = 0x0302;
constexpr uint16_t kDtrAndRts = 3;

}  // namespace

constexpr size_t AvrUsbHost::kBufferBytes;
constexpr size_t AvrUsbHost::kPacketBytes;

AvrUsbHost::AvrUsbHost(avr_t* avr)
    : avr_(avr),
      general_vector_(find_vector(avr, kGeneralVector)),
      endpoint_vector_(find_vector(avr, kEndpointVector)) {
  ueintx_tap_.attach(avr_, reg::kUeintx, &AvrUsbHost::on_ueintx_write, this);
  udien_tap_.attach(avr_, reg::kUdien, &AvrUsbHost::on_udien_write, this);
  ueienx_tap_.attach(avr_, reg::kUeienx, &AvrUsbHost::on_ueienx_write, this);
}

void AvrUsbHost::reset() {
  detach();
  suspended_ = false;
}

void AvrUsbHost::start() {
  avr_->data[reg::kUsbsta] = plugged_ ? 1 : 0;  // VBUS
  avr_cycle_timer_register(avr_, kTickCycles, &AvrUsbHost::on_tick, this);
}

void AvrUsbHost::set_cable(bool plugged) {
  if (plugged == plugged_) return;
  plugged_ = plugged;
  avr_->data[reg::kUsbsta] = plugged ? 1 : 0;
  detach();
}

void AvrUsbHost::set_port(bool open, uint32_t baud) {
  if (!open) to_board_.clear();
  port_open_ = open;
  if (baud != baud_) line_coding_sent_ = false;
  baud_ = baud;
}

void AvrUsbHost::reset_bus() {
  if (!configured()) return;
  detach();
  avr_ioctl(avr_, AVR_IOCTL_USB_RESET, nullptr);
  state_ = State::kEnumerating;
  enumeration_step_ = kSetAddressStep;
}

void AvrUsbHost::detach() {
  state_ = State::kDetached;
  stage_ = Stage::kIdle;
  state_ticks_ = 0;
  idle_ticks_ = 0;
  enumeration_step_ = 0;
  pause_left_ticks_ = 0;
  port_sent_open_ = false;
  line_coding_sent_ = false;
  to_board_.clear();
  from_board_.clear();
}

bool AvrUsbHost::attached() const {
  const bool enabled = (avr_->data[reg::kUsbcon] & 0x80) != 0;  // USBE
  const bool detached = (avr_->data[reg::kUdcon] & 0x01) != 0;  // DETACH
  return plugged_ && enabled && !detached;
}

avr_cycle_count_t AvrUsbHost::on_tick(avr_t*, avr_cycle_count_t when, void* self) {
  static_cast<AvrUsbHost*>(self)->tick();
  return when + kTickCycles;
}

void AvrUsbHost::tick() {
  ++ticks_;
  ++state_ticks_;
  if (!attached()) {
    if (state_ != State::kDetached) detach();
    suspend();
    return;
  }
  switch (state_) {
    case State::kDetached:
      state_ = State::kDebounce;
      state_ticks_ = 0;
      return;
    case State::kDebounce:
      if (state_ticks_ < kDebounceTicks) return;
      suspended_ = false;
      idle_ticks_ = 0;
      avr_ioctl(avr_, AVR_IOCTL_USB_RESET, nullptr);
      state_ = State::kReset;
      state_ticks_ = 0;
      return;
    case State::kReset:
      frame();
      if (state_ticks_ < kResetTicks) return;
      state_ = State::kEnumerating;
      return;
    case State::kEnumerating:
      frame();
      if (!run_half_transfers()) enumerate();
      return;
    case State::kConfigured:
      frame();
      if (!run_half_transfers()) run_port_requests();
      carry_bytes();
      return;
  }
}

void AvrUsbHost::raise_device_event(uint8_t bit) {
  const uint8_t mask = static_cast<uint8_t>(1 << bit);
  avr_->data[reg::kUdint] |= mask;
  if ((avr_->data[reg::kUdien] & mask) != 0) avr_raise_interrupt(avr_, general_vector_);
}

// The interrupts of the bus are levels: an event that was masked when it came interrupts when it is
// unmasked, and one that is masked before its interrupt was taken does not interrupt any more.
void AvrUsbHost::on_udien_write(void* self, uint8_t value) {
  AvrUsbHost& host = *static_cast<AvrUsbHost*>(self);
  if ((host.avr_->data[reg::kUdint] & value) != 0) {
    avr_raise_interrupt(host.avr_, host.general_vector_);
  } else {
    avr_clear_interrupt(host.avr_, host.general_vector_);
  }
}

// simavr keeps an endpoint's interrupt pending when it is masked.
void AvrUsbHost::on_ueienx_write(void* self, uint8_t value) {
  AvrUsbHost& host = *static_cast<AvrUsbHost*>(self);
  if (value == 0) avr_clear_interrupt(host.avr_, host.endpoint_vector_);
}

// Traffic on the bus sets WAKEUPI again and again, suspended or not.
void AvrUsbHost::frame() {
  if (ticks_ % kTicksPerMs != 0) return;
  raise_device_event(kWakeUp);
  frame_number_ = (frame_number_ + 1) & 0x7FF;
  avr_->data[reg::kUdfnuml] = static_cast<uint8_t>(frame_number_);
  avr_->data[reg::kUdfnumh] = static_cast<uint8_t>(frame_number_ >> 8);
  raise_device_event(kStartOfFrame);
}

void AvrUsbHost::suspend() {
  const bool running = (avr_->data[reg::kUsbcon] & 0x80) != 0 && (avr_->data[reg::kUdcon] & 1) == 0;
  if (!running || suspended_) return;
  if (++idle_ticks_ < kSuspendTicks) return;
  suspended_ = true;
  raise_device_event(kSuspend);
}

// What an operating system asks of a new CDC device, in order.
void AvrUsbHost::enumerate() {
  static const Request kSteps[] = {
      {kStandardIn, kGetDescriptor, kDeviceDescriptor, 0, 64},
      {kStandardOut, kSetAddress, 1, 0, 0},
      {kStandardIn, kGetDescriptor, kDeviceDescriptor, 0, 18},
      {kStandardIn, kGetDescriptor, kConfigurationDescriptor, 0, 9},
      {kStandardIn, kGetDescriptor, kConfigurationDescriptor, 0, 75},
      {kStandardIn, kGetDescriptor, kProductString, 0x0409, 255},
      {kStandardOut, kSetConfiguration, 1, 0, 0},
  };
  if (stage_ == Stage::kIdle) begin_request(kSteps[enumeration_step_]);
  if (!run_request()) return;
  if (++enumeration_step_ < sizeof kSteps / sizeof kSteps[0]) return;
  state_ = State::kConfigured;
  state_ticks_ = 0;
}

void AvrUsbHost::run_port_requests() {
  if (stage_ == Stage::kIdle) {
    if (!line_coding_sent_ && port_open_) {
      begin_request({kClassInterfaceOut, kSetLineCoding, 0, 0, 7});
    } else if (port_open_ != port_sent_open_) {
      const uint16_t lines = port_open_ ? kDtrAndRts : 0;
      begin_request({kClassInterfaceOut, kSetControlLineState, lines, 0, 0});
    } else {
      return;
    }
  }
  if (!run_request()) return;
  if (request_.request == kSetLineCoding) {
    line_coding_sent_ = true;
  } else {
    port_sent_open_ = request_.value != 0;
  }
}

void AvrUsbHost::begin_request(const Request& request) {
  request_ = request;
  stage_ = Stage::kSetup;
  request_ticks_ = 0;
  request_done_ = 0;
  setup_taken_ = false;
  data_taken_ = true;
  send_setup(request);
}

// The board waits for the data of a line coding; the next SETUP ends the transfer before.
bool AvrUsbHost::run_half_transfers() {
  if (half_transfer_ticks_ == 0) return false;
  stage_ = Stage::kIdle;
  if (ticks_ % half_transfer_ticks_ == 0) send_setup({kClassInterfaceOut, kSetLineCoding, 0, 0, 7});
  return true;
}

void AvrUsbHost::send_setup(const Request& request) {
  uint8_t packet[8] = {request.type,
                       request.request,
                       static_cast<uint8_t>(request.value),
                       static_cast<uint8_t>(request.value >> 8),
                       static_cast<uint8_t>(request.index),
                       static_cast<uint8_t>(request.index >> 8),
                       static_cast<uint8_t>(request.length),
                       static_cast<uint8_t>(request.length >> 8)};
  uint32_t size = sizeof packet;
  if (transfer(AVR_IOCTL_USB_SETUP, 0, packet, size) < 0) stage_ = Stage::kIdle;
}

// The board has read a packet when it clears the packet's flag with endpoint 0 selected. Only then
// may the next one follow: simavr keeps both directions of endpoint 0 in one buffer.
void AvrUsbHost::on_ueintx_write(void* self, uint8_t value) {
  AvrUsbHost& host = *static_cast<AvrUsbHost*>(self);
  if (host.avr_->data[reg::kUenum] != 0) return;
  if ((value & kSetupReceived) == 0) host.setup_taken_ = true;
  if ((value & kOutReceived) == 0) host.data_taken_ = true;
}

// At most one stage of a control transfer per call; true when the transfer is complete.
bool AvrUsbHost::run_request() {
  if (++request_ticks_ > kRequestTimeoutTicks) give_up();
  if (pause_left_ticks_ > 0) {
    --pause_left_ticks_;
    return false;
  }
  const Stage stage = stage_;
  const uint16_t done = request_done_;
  const bool complete = run_stage();
  if (stage_ != stage || request_done_ != done) pause_left_ticks_ = stage_pause_ticks_;
  return complete;
}

bool AvrUsbHost::run_stage() {
  uint8_t packet[kPacketBytes];
  uint32_t size = 0;
  switch (stage_) {
    case Stage::kIdle:
      return false;
    case Stage::kSetup:
      if (!setup_taken_) return false;
      if ((request_.type & kDeviceToHost) != 0) {
        stage_ = Stage::kDataIn;
      } else {
        stage_ = request_.length > 0 ? Stage::kDataOut : Stage::kStatusIn;
      }
      return false;
    case Stage::kDataIn:
      if (transfer(AVR_IOCTL_USB_READ, 0, packet, size) < 0) return false;
      request_done_ = static_cast<uint16_t>(request_done_ + size);
      if (size == kPacketBytes && request_done_ < request_.length) return false;
      stage_ = Stage::kStatusOut;
      return false;
    case Stage::kDataOut: {
      uint8_t coding[7] = {static_cast<uint8_t>(baud_),
                           static_cast<uint8_t>(baud_ >> 8),
                           static_cast<uint8_t>(baud_ >> 16),
                           static_cast<uint8_t>(baud_ >> 24),
                           0,
                           0,
                           8};
      size = sizeof coding;
      data_taken_ = false;
      if (transfer(AVR_IOCTL_USB_WRITE, 0, coding, size) >= 0) stage_ = Stage::kStatusIn;
      return false;
    }
    case Stage::kStatusIn:
      if (!data_taken_ || transfer(AVR_IOCTL_USB_READ, 0, packet, size) < 0) return false;
      stage_ = Stage::kIdle;
      return true;
    case Stage::kStatusOut:
      if (transfer(AVR_IOCTL_USB_WRITE, 0, packet, size) < 0) return false;
      stage_ = Stage::kIdle;
      return true;
  }
  return false;
}

// As an operating system does with a device that does not answer: reset the bus, start again.
void AvrUsbHost::give_up() {
  std::deque<uint8_t> kept;
  kept.swap(to_board_);
  detach();
  to_board_.swap(kept);
}

int AvrUsbHost::transfer(uint32_t ioctl, uint8_t endpoint, uint8_t* data, uint32_t& size) {
  avr_io_usb packet;
  packet.pipe = endpoint;
  packet.sz = size;
  packet.buf = data;
  const int result = avr_ioctl(avr_, ioctl, &packet);
  size = packet.sz;
  return result;
}

void AvrUsbHost::carry_bytes() {
  uint8_t packet[kPacketBytes];
  if (!to_board_.empty()) {
    uint32_t size = static_cast<uint32_t>(std::min(to_board_.size(), kPacketBytes));
    std::copy_n(to_board_.begin(), size, packet);
    if (transfer(AVR_IOCTL_USB_WRITE, kOutEndpoint, packet, size) >= 0) {
      to_board_.erase(to_board_.begin(), to_board_.begin() + static_cast<std::ptrdiff_t>(size));
    }
  }
  if (!port_open_ || from_board_.size() + kPacketBytes > kBufferBytes) return;
  uint32_t size = 0;
  if (transfer(AVR_IOCTL_USB_READ, kInEndpoint, packet, size) < 0) return;
  from_board_.insert(from_board_.end(), packet, packet + size);
}

size_t AvrUsbHost::write(const uint8_t* data, size_t n) {
  if (!plugged_ || !port_open_) return 0;
  const size_t taken = std::min(n, kBufferBytes - std::min(kBufferBytes, to_board_.size()));
  to_board_.insert(to_board_.end(), data, data + taken);
  return taken;
}

size_t AvrUsbHost::read(uint8_t* data, size_t capacity) {
  const size_t given = std::min(capacity, from_board_.size());
  std::copy_n(from_board_.begin(), given, data);
  from_board_.erase(from_board_.begin(), from_board_.begin() + static_cast<std::ptrdiff_t>(given));
  return given;
}

}  // namespace emulator
}  // namespace tfsat
